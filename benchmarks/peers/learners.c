/* Other tabular learners as they are written from a textbook: float64, one period after the other. */
#include <stdlib.h>
#include <string.h>

#include "choosing.h"

enum { SARSA, EXPECTED_SARSA, DOUBLE_Q, N_STEP, Q_LAMBDA, DYNA_Q };

static double expectation(const double *q, double epsilon) {
    double best = maximum(q), mean = 0;
    int count = 0;
    for (int a = 0; a < 4; a++) count += q[a] == best;
    for (int a = 0; a < 4; a++) {
        double share = q[a] == best ? 1.0 / count : 0.0;
        mean += ((1 - epsilon) * share + epsilon * (1 - share) / 3) * q[a];
    }
    return mean;
}

static double *q, *other;      /* Q-matrix; second Q-matrix, traces, or rewards of the model */
static int *next, *met, *list; /* next state of the model, -1 terminal; states met; entries with a trace */
static uint8_t *taken;         /* actions taken in each state */
static int known, traced;

static int choose_of_two(int state, double epsilon) {
    double sum[4];
    for (int a = 0; a < 4; a++) sum[a] = q[4 * state + a] + other[4 * state + a];
    return choose(sum, epsilon);
}

static void learn_step(const Job *job, int kind, int count, int state, int action, double reward, int following,
                       int next_action, double epsilon) {
    double *at = &q[4 * state + action];
    const double *then = following < 0 ? 0 : q + 4 * following;
    switch (kind) {
    case SARSA:
        *at += job->alpha * (reward + job->gamma * (then ? then[next_action] : 0) - *at);
        break;
    case EXPECTED_SARSA:
        *at += job->alpha * (reward + job->gamma * (then ? expectation(then, epsilon) : 0) - *at);
        break;
    case DOUBLE_Q: {
        double *one = random_word() >> 31 ? q : other, *judge = one == q ? other : q;
        double value = then ? judge[4 * following + greedy(one + 4 * following)] : 0;
        one[4 * state + action] += job->alpha * (reward + job->gamma * value - one[4 * state + action]);
        break;
    }
    case Q_LAMBDA: {
        double error = reward + job->gamma * (then ? maximum(then) : 0) - *at;
        if (other[4 * state + action] == 0) list[traced++] = 4 * state + action;
        other[4 * state + action] = 1;
        for (int i = 0; i < traced; i++) q[list[i]] += job->alpha * error * other[list[i]];
        break;
    }
    case DYNA_Q:
        *at += job->alpha * (reward + job->gamma * (then ? maximum(then) : 0) - *at);
        if (!taken[state]) met[known++] = state;
        taken[state] |= 1 << action;
        other[4 * state + action] = reward;
        next[4 * state + action] = following;
        for (int i = 0; i < count; i++) {
            int s = met[below(known)], tried[4], n = 0;
            for (int a = 0; a < 4; a++)
                if (taken[s] >> a & 1) tried[n++] = a;
            int e = 4 * s + tried[below(n)];
            q[e] += job->alpha * (other[e] + job->gamma * (next[e] < 0 ? 0 : maximum(q + 4 * next[e])) - q[e]);
        }
    }
}

static void decay_traces(double factor) {
    int kept = 0;
    for (int i = 0; i < traced; i++) {
        double trace = other[list[i]] * factor;
        other[list[i]] = trace < 1e-8 ? 0 : trace;
        if (trace >= 1e-8) list[kept++] = list[i];
    }
    traced = kept;
}

static int pick(int kind, int state, double epsilon, double factor) {
    if (kind == DOUBLE_Q) return choose_of_two(state, epsilon);
    int action = choose(q + 4 * state, epsilon);
    if (kind == Q_LAMBDA) decay_traces(q[4 * state + action] == maximum(q + 4 * state) ? factor : 0);
    return action;
}

static int trial(const Job *job, int kind, int count, double decay, const int32_t *next_cell, const int32_t *layout,
                 double epsilon) {
    int cell = layout[0], reached = 0, steps = 0, state = cell, ring = count + 1;
    int passed[64];
    double gains[64];
    if (kind == Q_LAMBDA) decay_traces(0);
    int action = pick(kind, state, epsilon, 0), next_action = 0;
    for (;;) {
        cell = next_cell[action * job->cells + cell];
        double reward = job->step_reward;
        if (cell == layout[1 + reached]) {
            reached++;
            reward = reached == job->goals ? job->final_goal_reward : job->sub_goal_reward;
        }
        int terminal = reached == job->goals, ended = terminal || steps + 1 == job->max_steps;
        int following = terminal ? -1 : reached * job->cells + cell;
        if ((kind == SARSA || kind == N_STEP) && !terminal) next_action = pick(kind, following, epsilon, 0);
        if (kind == N_STEP) {
            passed[steps % ring] = 4 * state + action;
            gains[steps % ring] = reward;
            int first = steps - count + 1, last = ended ? steps : first;
            for (int began = first > 0 ? first : 0; began <= last; began++) {
                double target = 0, discount = 1;
                for (int i = began; i <= steps; i++, discount *= job->gamma) target += discount * gains[i % ring];
                if (!terminal) target += discount * q[4 * following + next_action];
                q[passed[began % ring]] += job->alpha * (target - q[passed[began % ring]]);
            }
        } else
            learn_step(job, kind, count, state, action, reward, following, next_action, epsilon);
        steps++;
        if (ended) return steps;
        state = following;
        action = kind == SARSA || kind == N_STEP ? next_action : pick(kind, state, epsilon, job->gamma * decay);
    }
}

void learn(const Job *job, int kind, int count, double decay, const int32_t *next_cell, const double *epsilon,
           const int32_t *layouts, int periods, uint64_t seed, int64_t *total) {
    size_t states = (size_t)job->goals * job->cells;
    rng = seed * 0x9E3779B97F4A7C15u + 1;
    q = malloc(4 * states * sizeof *q);
    other = malloc(4 * states * sizeof *other);
    next = malloc(4 * states * sizeof *next);
    list = malloc(4 * states * sizeof *list);
    met = malloc(states * sizeof *met);
    taken = malloc(states);
    for (int p = 0; p < periods; p++) {
        memset(q, 0, 4 * states * sizeof *q);
        memset(other, 0, 4 * states * sizeof *other);
        memset(taken, 0, states);
        known = traced = 0;
        total[p] = 0;
        for (int t = 0; t < job->trials; t++)
            total[p] += trial(job, kind, count, decay, next_cell, layouts + p * (1 + job->goals), epsilon[t]);
    }
    free(q), free(other), free(next), free(list), free(met), free(taken);
}
