/* A planner in C: action = p (goal - q) - k u, with the goal where the preview ends, if there is one. It speaks the protocol of docs/isolation.md over stdin and stdout.
 *
 *     cc -O2 -o towards towards.c
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST 64 /* actions */

/* Where an array of the observation lies among its numbers. */
typedef struct {
    long offset, length;
} Place;

static char *line = NULL; /* the header of the last message */
static size_t room = 0;

/* The text after "key": in the header; NULL when there is none. */
static const char *after(const char *key) {
    char quoted[80];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *found = strstr(line, quoted);
    return found ? found + strlen(quoted) : NULL;
}

static double number(const char *key, double otherwise) {
    const char *text = after(key);
    return text ? strtod(text, NULL) : otherwise;
}

static Place place(const char *key) {
    Place found = {-1, 0};
    const char *text = after(key);
    if (text) sscanf(text, "[%ld,%ld", &found.offset, &found.length);
    return found;
}

/* Where the last prediction of the first goal lies, or the goal itself without a preview. */
static Place goal_ahead(void) {
    Place found = place("goal_position");
    const char *text = strstr(line, "_preview\":"); /* goal_NAME_preview; goals come before obstacles */
    long offset, length, steps, size;
    if (text && sscanf(text, "_preview\":[%ld,%ld,[%ld,%ld", &offset, &length, &steps, &size) == 4) {
        found.offset = offset + length - size;
        found.length = size;
    }
    return found;
}

static int is(const char *type) {
    const char *text = after("type");
    return text && strncmp(text + 1, type, strlen(type)) == 0;
}

static void answer(const char *header) {
    puts(header);
    fflush(stdout);
}

int main(void) {
    double p = 1.0, k = 2.0; /* [1/s^2], [1/s] */
    Place q = {-1, 0}, u = {-1, 0}, goal = {-1, 0};
    double *seen = NULL;
    while (getline(&line, &room, stdin) > 0) {
        size_t bytes = (size_t)number("bytes", 0);
        seen = realloc(seen, bytes + 1);
        if (!seen || fread(seen, 1, bytes, stdin) != bytes) return 1;
        if (is("start")) {
            answer("{\"type\":\"started\"}");
        } else if (is("setup")) {
            p = number("p", 1.0);
            k = number("k", 2.0);
            answer("{\"type\":\"ready\"}");
        } else if (is("observation")) {
            q = place("q");
            u = place("u");
            goal = goal_ahead();
        } else if (is("call")) {
            if (goal.length != q.length || u.length != q.length || q.length > MOST) {
                answer("{\"type\":\"error\",\"message\":\"towards moves a point or base to a position, nothing else\"}");
                continue;
            }
            double action[MOST];
            struct timespec started, ended;
            clock_gettime(CLOCK_MONOTONIC, &started);
            for (long i = 0; i < q.length; i++)
                action[i] = p * (seen[goal.offset + i] - seen[q.offset + i]) - k * seen[u.offset + i];
            clock_gettime(CLOCK_MONOTONIC, &ended);
            long wall_ns = (ended.tv_sec - started.tv_sec) * 1000000000L + ended.tv_nsec - started.tv_nsec;
            printf("{\"type\":\"action\",\"wall_ns\":%ld,\"bytes\":%ld}\n", wall_ns, 8 * q.length);
            fwrite(action, 8, (size_t)q.length, stdout);
            fflush(stdout);
        } else if (is("close")) {
            answer("{\"type\":\"closed\"}");
        }
    }
    return 0;
}
