/* Tabular Q-learning as it is written from a textbook: float64, one period after the other. */
#include <string.h>

#include "choosing.h"

static int trial(const Job *job, double *q, const int32_t *next_cell, const int32_t *layout, double epsilon) {
    int cell = layout[0], reached = 0, steps = 0;
    while (reached < job->goals && steps < job->max_steps) {
        double *row = q + 4 * (reached * job->cells + cell);
        int action = choose(row, epsilon);
        cell = next_cell[action * job->cells + cell];
        steps++;
        double reward = job->step_reward;
        if (cell == layout[1 + reached]) {
            reached++;
            reward = reached == job->goals ? job->final_goal_reward : job->sub_goal_reward;
        }
        double target = reward;
        if (reached < job->goals) target += job->gamma * maximum(q + 4 * (reached * job->cells + cell));
        row[action] += job->alpha * (target - row[action]);
    }
    return steps;
}

void learn(const Job *job, const int32_t *next_cell, const double *epsilon, const int32_t *layouts, int periods,
           uint64_t seed, double *q, int64_t *total) {
    rng = seed * 0x9E3779B97F4A7C15u + 1;
    for (int p = 0; p < periods; p++) {
        memset(q, 0, sizeof(double) * 4 * job->goals * job->cells);
        total[p] = 0;
        for (int t = 0; t < job->trials; t++)
            total[p] += trial(job, q, next_cell, layouts + p * (1 + job->goals), epsilon[t]);
    }
}
