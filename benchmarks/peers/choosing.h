/* The job of textbook C, its random numbers, and its choice of actions. */
#include <stdint.h>

typedef struct {
    int cells, goals, trials, max_steps;
    double alpha, gamma, step_reward, sub_goal_reward, final_goal_reward;
} Job;

static uint64_t rng;

/* xorshift64* */
static uint32_t random_word(void) {
    rng ^= rng >> 12;
    rng ^= rng << 25;
    rng ^= rng >> 27;
    return (uint32_t)(rng * 2685821657736338717u >> 32);
}

static int below(int n) { return (int)((uint64_t)random_word() * n >> 32); }

static double maximum(const double *q) {
    double best = q[0];
    for (int a = 1; a < 4; a++)
        if (q[a] > best) best = q[a];
    return best;
}

/* A random one of the best actions. */
static int greedy(const double *q) {
    double best = maximum(q);
    int tied[4], count = 0;
    for (int a = 0; a < 4; a++)
        if (q[a] == best) tied[count++] = a;
    return count == 1 ? tied[0] : tied[below(count)];
}

static int choose(const double *q, double epsilon) {
    int best = greedy(q);
    if (random_word() * 0x1p-32 >= epsilon) return best;
    int other = below(3);
    return other + (other >= best);
}
