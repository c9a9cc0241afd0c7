/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Who may touch whom: a cell grid fills a list (ry_pairs) of the pairs nearer than contact plus the
 * skins of both (Verlet 1967); it holds until some grain has left its own. */
#ifndef RY_STAGE_NEIGHBOR_H
#define RY_STAGE_NEIGHBOR_H

#include "stage/blocks.h"
#include "store/pairs.h"
#include "store/state.h"

/* A flat wall: z = 0, x = 0, x = length. The order gives the walls their ids. */
typedef enum ry_wall { RY_WALL_FLOOR, RY_WALL_LEFT, RY_WALL_RIGHT } ry_wall;

/* Positions as whole numbers, the distance of which is that of the nearest images where x is periodic. */
typedef struct ry_raster {
    double per_x, per_z, zero_x, most_x; /* units per metre, where x = 0 is, and the last one */
    double margin; /* [m] */
    float x, z;    /* a unit [m] */
} ry_raster;

typedef struct ry_bounds {
    double left, right, bottom, top; /* [m] */
} ry_bounds;

/* Cells of equal size, column by column. */
typedef struct ry_grid {
    double reach;        /* of the furthest grain, and what rounding takes [m] */
    ry_bounds box;       /* what is outside counts as at its edge */
    double per_x, per_z; /* cells per metre */
    int32_t columns, rows;
} ry_grid;

/* See stage/skin.h. */
typedef struct ry_skin {
    int on;              /* else the skins stay as they are */
    double d, dt, room;  /* [m, s, m] */
    double steps;        /* of the horizon */
    double change;       /* by which these are multiplied next */
    double cost, looked; /* of a step in the lists before; of all steps since: in pairs that are looked at */
    int lists;           /* since then */
    int64_t rebuilds;    /* of all, up to the last */
    int64_t began, last; /* steps: when the first of them was made (-1: none yet), and the last */
} ry_skin;

typedef struct ry_neighbor {
    double length;   /* of the domain [m] */
    int periodic;
    int n_walls;
    ry_wall wall[RY_MAX_WALLS];
    /* A grain may go this far before the list is made anew: skin_least + horizon x speed, at most skin_most, but
     * what two steps take it at the least. */
    double skin_least, skin_most, horizon; /* [m, m, s] */
    double step;     /* of time [s] */
    ry_skin skin;
    double radius_max; /* [m] */
    int threads;
    int64_t rebuilds;
    ry_blocks *blocks; /* laid for each new list; NULL: nobody goes through it */
    const uint8_t *still; /* 1: two of them make no pair: grains that are fixed, or asleep */
    int has_sleepers;     /* grains that are still but not near any other are common: look for nobody near them */
    const int32_t *was;   /* where each grain lay in memory when the list was made; NULL: where it lies now */
    double *x0, *z0; /* where the grains were at the last rebuild; x0 wraps with x [m] */
    float *limit2;   /* square of how far each may go from there [m^2] */

    /* scratch of a rebuild */
    ry_grid grid;
    size_t n_cells_room;
    int32_t *cell_start, *member; /* grains by cell; with sleepers they are known after the rebuild, too */
    int32_t *own_member;          /* is `member` then; else NULL */
    ry_raster raster;
    uint32_t *member_x, *member_z; /* where they are, in units of the raster */
    float *member_reach;
    uint8_t *busy; /* cells: who is there may touch a grain that is not still; NULL without sleepers */
    size_t n_busy_room;
    struct ry_found {
        int32_t *near; /* of one grain */
        size_t room;
        struct ry_part { int32_t *j; size_t room, n; int full; } above, below; /* partners of its grains */
    } *found; /* one per thread */
    struct ry_old {  /* the memory of the list before */
        int32_t *row, *j;
        double *slip, *rest, *wet;
        uint8_t *age;
        int32_t *wall_slot[RY_MAX_WALLS];
        size_t room;
    } old;
} ry_neighbor;

ry_status ry_neighbor_create(ry_neighbor *neighbor, const ry_grains *grains, int threads, ry_error *error);
void ry_neighbor_free(ry_neighbor *neighbor);

/* dx, or the nearest of its periodic images; half = length/2, infinite where x is not periodic [m]. */
RY_INLINE double ry_nearest(double dx, double length, double half)
{
    return dx > half ? dx - length : (dx < -half ? dx + length : dx);
}

/* Storage indices in ascending id. */
RY_INLINE void ry_sort_by_id(int32_t *j, size_t n, const int32_t *id)
{
    for (size_t p = 1; p < n; p++) {
        const int32_t moving = j[p];
        size_t q = p;
        for (; q > 0 && id[j[q - 1]] > id[moving]; q--) {
            j[q] = j[q - 1];
        }
        j[q] = moving;
    }
}

/* How far the furthest grain has gone since the last rebuild, in whose grid ry_neighbor_around looks [m]. */
double ry_neighbor_strayed(const ry_neighbor *neighbor, const ry_grains *grains);

/* Grains (k among them) whose surface is nearer than `gap` to that of grain k, in ascending id, as they lie now; `gap`
 * any, `strayed` as above [m]. The *n grains are in *near until the next call. */
ry_status ry_neighbor_around(ry_neighbor *neighbor, const ry_grains *grains, int32_t k, double gap, double strayed,
                             const int32_t **near, int32_t *n, ry_error *error);

/* Makes the list anew; the memory of contacts goes along. */
ry_status ry_neighbor_rebuild(ry_neighbor *neighbor, const ry_grains *grains, ry_pairs *pairs,
                              ry_error *error);

#endif
