/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ry_config: what the user asked. Plain values, SI units; made by ry_config_load from a scene file
 * or by ry_config_default and assignments, then completed and checked by ry_config_resolve. */
#ifndef RYUSA_CONFIG_H
#define RYUSA_CONFIG_H

#include <math.h>
#include <stdint.h>

#include "ryusa/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Every choice: RY_NAME(enum value, "word in a scene file"). The order is part of the file format. */
#define RY_LIST_floor(RY_NAME) \
    RY_NAME(RY_FLOOR_NONE, "none") RY_NAME(RY_FLOOR_FLAT, "flat") RY_NAME(RY_FLOOR_ROUGH, "rough")
#define RY_LIST_packing(RY_NAME)                                                     \
    RY_NAME(RY_PACKING_SQUARE, "square") RY_NAME(RY_PACKING_HEXAGONAL, "hexagonal")  \
    RY_NAME(RY_PACKING_RANDOM, "random")
#define RY_LIST_law(RY_NAME)                                                              \
    RY_NAME(RY_LAW_ENERGY, "energy") RY_NAME(RY_LAW_FUJIOKA2, "fujioka-2")                \
    RY_NAME(RY_LAW_FUJIOKA2_PRINTED, "fujioka-2-printed")                                 \
    RY_NAME(RY_LAW_FUJIOKA1, "fujioka-1") RY_NAME(RY_LAW_CUNDALL, "cundall")              \
    RY_NAME(RY_LAW_CUNDALL_TENSION, "cundall-tension") RY_NAME(RY_LAW_TANAKA, "tanaka")
#define RY_LIST_mapping(RY_NAME) \
    RY_NAME(RY_MAPPING_USUAL, "usual") RY_NAME(RY_MAPPING_EXACT, "exact")
#define RY_LIST_fluid(RY_NAME)                                                  \
    RY_NAME(RY_FLUID_NONE, "none") RY_NAME(RY_FLUID_STRESS, "stress")           \
    RY_NAME(RY_FLUID_LOG, "log") RY_NAME(RY_FLUID_BALANCE, "balance")
#define RY_LIST_drag(RY_NAME)                                                               \
    RY_NAME(RY_DRAG_DALLAVALLE, "dallavalle") RY_NAME(RY_DRAG_SCHILLER, "schiller-naumann") \
    RY_NAME(RY_DRAG_FERGUSON, "ferguson-church")
#define RY_LIST_mixing(RY_NAME) \
    RY_NAME(RY_MIXING_LI_SAWAMOTO, "li-sawamoto") RY_NAME(RY_MIXING_DURAN, "duran") \
    RY_NAME(RY_MIXING_DURAN_MOVING, "duran-moving")
#define RY_LIST_turbulence(RY_NAME) RY_NAME(RY_TURBULENCE_NONE, "none") RY_NAME(RY_TURBULENCE_WALK, "walk")
#define RY_LIST_start(RY_NAME) RY_NAME(RY_START_REST, "rest") RY_NAME(RY_START_MOTION, "motion")
#define RY_LIST_order(RY_NAME)                                             \
    RY_NAME(RY_ORDER_ID, "id") RY_NAME(RY_ORDER_BED, "bed")                \
    RY_NAME(RY_ORDER_SHUFFLED, "shuffled")

#define RY_NAME_ENUM(value, word) value,
typedef enum { RY_LIST_floor(RY_NAME_ENUM) RY_FLOOR_COUNT } ry_floor;
typedef enum { RY_LIST_packing(RY_NAME_ENUM) RY_PACKING_COUNT } ry_packing;
typedef enum { RY_LIST_law(RY_NAME_ENUM) RY_LAW_COUNT } ry_law;
typedef enum { RY_LIST_mapping(RY_NAME_ENUM) RY_MAPPING_COUNT } ry_mapping;
typedef enum { RY_LIST_fluid(RY_NAME_ENUM) RY_FLUID_COUNT } ry_fluid;
typedef enum { RY_LIST_drag(RY_NAME_ENUM) RY_DRAG_COUNT } ry_drag;
typedef enum { RY_LIST_mixing(RY_NAME_ENUM) RY_MIXING_COUNT } ry_mixing;
typedef enum { RY_LIST_turbulence(RY_NAME_ENUM) RY_TURBULENCE_COUNT } ry_turbulence;
typedef enum { RY_LIST_start(RY_NAME_ENUM) RY_START_COUNT } ry_start;
typedef enum { RY_LIST_order(RY_NAME_ENUM) RY_ORDER_COUNT } ry_order;
#undef RY_NAME_ENUM

/* One explicit grain of the list `particles`. */
typedef struct ry_particle {
    double position[2]; /* x, z [m] */
    double velocity[2]; /* [m/s] */
    double spin;        /* about y, positive from z towards x (clockwise seen with x right, z up) [rad/s] */
    double diameter;    /* [m] */
    double density;     /* [kg/m^3] */
    int fixed;          /* nothing moves it */
    int line;           /* where in its file it stands, for messages; 0: no file */
    int table;          /* its file: 0 the scene, k tables[k - 1] of the config */
} ry_particle;

/* What can be asked for in output.fields, as bits. RY_FIELD(bit, "word", text) */
#define RY_LIST_field(RY_FIELD)                                                      \
    RY_FIELD(RY_FIELD_POSITION, "position", "trajectory of the centres")             \
    RY_FIELD(RY_FIELD_VELOCITY, "velocity", "velocities")                            \
    RY_FIELD(RY_FIELD_SPIN, "spin", "angular velocities")                            \
    RY_FIELD(RY_FIELD_FLUX, "flux", "q_star, q_b, bed_level and kinetic_energy")     \
    RY_FIELD(RY_FIELD_ENERGY, "energy", "the rows of the energy ledger")             \
    RY_FIELD(RY_FIELD_PROFILE, "profile", "profiles over height")
#define RY_FIELD_ENUM(bit, word, text) bit##_INDEX,
enum { RY_LIST_field(RY_FIELD_ENUM) RY_FIELD_COUNT };
#undef RY_FIELD_ENUM
#define RY_FIELD_BIT(bit, word, text) bit = 1 << bit##_INDEX,
enum { RY_LIST_field(RY_FIELD_BIT) RY_FIELD_ALL = (1 << RY_FIELD_COUNT) - 1 };
#undef RY_FIELD_BIT

#define RY_DERIVED NAN /* "follows from other parameters" */

typedef struct ry_config {
#define RY_REAL(section, key, ...) double section##_##key;
#define RY_INT(section, key, ...) int section##_##key;
#define RY_FLAG(section, key, ...) int section##_##key;
#define RY_CHOICE(section, key, list, ...) ry_##list section##_##key;
#include "ryusa/config.def"
#undef RY_REAL
#undef RY_INT
#undef RY_FLAG
#undef RY_CHOICE
    unsigned output_fields;  /* bits RY_FIELD_... */
    int has_grains;          /* the scene has a section `grains` */
    ry_particle *particles;  /* explicit grains; owned, see ry_config_free */
    int n_particles;
    char **tables;           /* names of the tables that particles come from; owned */
    int n_tables;
    char *title;             /* owned; "" if none */
    char *text;              /* the scene file as it was read, then the -s overrides as comments; owned */
    char *path;              /* the scene file's name, for messages; owned; "" if none */
    uint32_t guard;          /* set by ry_config_default: a stale or zeroed struct is refused */
} ry_config;

/* The defaults of a scene with (1) or without (0) a section `grains`. */
RY_API ry_config ry_config_default(int has_grains);

/* Reads a scene file, applies the `n_overrides` texts "key.path=value", resolves and checks. Lines
 * "# -s key.path=value" at the end of the file are overrides too: config->text alone makes the same
 * config again, as long as the tables of particles that it names are there. On failure the config is zeroed.
 * Errors: RY_BAD_INPUT with "file:line: key: what is wrong; what is allowed", RY_BAD_FILE. */
RY_API ry_status ry_config_load(ry_config *config, const char *path, const char *const *overrides,
                                int n_overrides, ry_error *error);

/* The same from text in memory (a resumed run's stored scene); `name` is used in messages. */
RY_API ry_status ry_config_parse(ry_config *config, const char *text, const char *name,
                                 const char *const *overrides, int n_overrides, ry_error *error);

/* Fills in what is derived and checks what no single range can (see docs/parameters.md). Idempotent.
 * Still NAN afterwards: contact_stiffness where alpha_m rules, fluid_shear_stress where shields does,
 * stop_flux_error (off), numerics_skin (chosen by the program), domain_length of an unbounded scene. */
RY_API ry_status ry_config_resolve(ry_config *config, ry_error *error);

RY_API void ry_config_free(ry_config *config);

/* What follows from a resolved config; all SI. Computed, never stored. */
typedef struct ry_derived {
    double d;             /* slab width, unit of lengths: grains.diameter, whatever a bed's grains come to; without a bed
                             the mean diameter of the explicit grains that can move [m] */
    double mass;          /* dry mass of that mean grain, the m of alpha_m and alpha_cn [kg] */
    double density;       /* density of the mean grain [kg/m^3] */
    int is_bed;           /* many contacts per grain are to be expected */
    double stiffness;     /* k [N/m] */
    double damping;       /* eta = alpha_cn beta 2 sqrt(m k) [N s/m] */
    double stiffness_t;   /* k_t [N/m] */
    double step_ratio;    /* a = k dt^2 / m_r of an equal pair, wet inertia [1] */
    double zeta_pair;     /* eta/(2 sqrt(m_r k)) of an equal pair [1] */
    double zeta_impact;   /* laws with the column ratio: damping ratio of every pair; NAN: the dashpot
                           * is `damping` (no restitution was given), or another law [1] */
    double restitution;   /* of a binary impact of an equal pair, exact for the law chosen [1] */
    double restitution_wall; /* the same against a wall or fixed grain [1] */
    double buoyant_gravity;  /* g' = (1 - rho_f/rho_s) g [m/s^2] */
    double shear_stress;  /* tau_b [Pa] */
    double shields;       /* theta [1] */
    double friction_velocity; /* u* = sqrt(tau_b/rho_f) [m/s] */
    double flux_unit;     /* sqrt((s-1) g d^3), dry sqrt(g d^3): q_b = q* x this [m^2/s] */
    double length;        /* of the domain along x; 0 if unbounded and not given [m] */
    long long steps_settle, steps_end; /* the step at which the fluid starts, the last step */
    int steps_frame;      /* steps between frames */
    int steps_series;     /* steps between samples of the series; divides steps_frame */
} ry_derived;
RY_API ry_derived ry_config_derive(const ry_config *config);

/* Restitution of an impact with a linear spring and dashpot that never pulls, damping ratio zeta
 * (Schwager & Poeschel 2007, Granular Matter 9, 465), and its inverse. */
RY_API double ry_restitution_from_damping(double zeta);
RY_API double ry_damping_from_restitution(double e);

/* Walks every parameter of config.def in order (for show, files, docs and comparisons). `value` is
 * printed with all digits in SI; `unit` is "1" for numbers, "" for words. Returns 0 past the end. */
typedef struct ry_parameter {
    const char *section, *key, *unit, *text;
    char type; /* 'r' real, 'i' integer, 'f' flag, 'c' choice */
    double low, high;       /* allowed range of a real or integer */
    double number;          /* value of r, i, f; index of c */
    const char *word;       /* value of a choice */
    const char *words[12];  /* the words a choice allows, NULL after the last */
} ry_parameter;
RY_API int ry_config_parameter(const ry_config *config, int index, ry_parameter *out);

#ifdef __cplusplus
}
#endif
#endif
