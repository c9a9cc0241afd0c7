/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Scene files: what is read, what is refused with which words (tests/bad), what follows from it. */
#include <dirent.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "ryusa/config.h"

#define BED "grains: {columns: 5, layers: 2}\n"

static ry_status parse(ry_config *config, const char *text, const char *override_, ry_error *error)
{
    *error = (ry_error){0};
    return ry_config_parse(config, text, "scene.yaml", &override_, override_ != NULL, error);
}

/* A config that must load. */
static ry_config good(const char *text, const char *override_)
{
    ry_config config;
    ry_error error;
    if (parse(&config, text, override_, &error) != RY_OK) {
        fail_msg("%s", error.text);
    }
    return config;
}

/* A scene that must fail with `part` in its message and leave an empty config. */
static void bad(const char *text, const char *override_, const char *part)
{
    ry_config config;
    ry_error error;
    assert_int_equal(parse(&config, text, override_, &error), RY_BAD_INPUT);
    assert_int_equal(error.status, RY_BAD_INPUT);
    if (strstr(error.text, part) == NULL) {
        fail_msg("'%s' is not in: %s", part, error.text);
    }
    assert_null(config.text);
    assert_int_equal(config.guard, 0);
}

static char *read_file(const char *path)
{
    static char text[1 << 20];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t length = fread(text, 1, sizeof text - 1, file);
    (void)fclose(file);
    text[length] = '\0';
    return text;
}

/* Two configs say the same, bit for bit, NAN equal to NAN. */
static void assert_same(const ry_config *a, const ry_config *b)
{
    ry_parameter p, q;
    for (int i = 0; ry_config_parameter(a, i, &p); i++) {
        assert_true(ry_config_parameter(b, i, &q));
        if (!(p.number == q.number || (isnan(p.number) && isnan(q.number)))) {
            fail_msg("%s.%s: %.17g and %.17g", p.section, p.key, p.number, q.number);
        }
    }
    assert_int_equal(a->has_grains, b->has_grains);
    assert_int_equal(a->output_fields, b->output_fields);
    assert_string_equal(a->title, b->title);
    assert_int_equal(a->n_particles, b->n_particles);
    for (int i = 0; i < a->n_particles; i++) {
        const ry_particle *s = &a->particles[i], *t = &b->particles[i];
        assert_memory_equal(s->position, t->position, sizeof s->position);
        assert_memory_equal(s->velocity, t->velocity, sizeof s->velocity);
        assert_true(s->spin == t->spin && s->diameter == t->diameter);
        assert_true(s->density == t->density && s->fixed == t->fixed);
    }
}

/* --- What is refused -------------------------------------------------------------------------- */

static void check_bad_scene(char *line)
{
    char path[600];
    char *rest = NULL;
    const char *name = strtok_r(line, "|\n", &rest);
    (void)snprintf(path, sizeof path, "%s/tests/bad/%.*s", RY_SOURCE_DIR, (int)strcspn(name, " "),
                   name);
    ry_config config;
    ry_error error = {0};
    const ry_status status = ry_config_load(&config, path, NULL, 0, &error);
    if (status != RY_BAD_INPUT || strncmp(error.text, path, strlen(path)) != 0) {
        if (strncmp(error.text, "-s ", 3) != 0) {
            fail_msg("%s: status %d: %s", path, (int)status, error.text);
        }
    }
    char *part;
    while ((part = strtok_r(NULL, "|\n", &rest)) != NULL) {
        part += strspn(part, " ");
        for (size_t n = strlen(part); n > 0 && part[n - 1] == ' '; n--) {
            part[n - 1] = '\0';
        }
        if (strstr(error.text, part) == NULL) {
            fail_msg("'%s' is not in: %s", part, error.text);
        }
    }
    assert_null(config.text);
}

static int count_bad_files(void)
{
    int n = 0;
    DIR *folder = opendir(RY_SOURCE_DIR "/tests/bad");
    assert_non_null(folder);
    for (const struct dirent *entry; (entry = readdir(folder)) != NULL;) {
        n += strstr(entry->d_name, ".yaml") != NULL;
    }
    (void)closedir(folder);
    return n;
}

static void bad_scenes_say_what_is_wrong(void **state)
{
    (void)state;
    char line[400];
    int n = 0;
    FILE *table = fopen(RY_SOURCE_DIR "/tests/bad/expected.txt", "r");
    assert_non_null(table);
    while (fgets(line, sizeof line, table) != NULL) {
        if (line[0] != '#') {
            check_bad_scene(line);
            n++;
        }
    }
    (void)fclose(table);
    assert_int_equal(n, count_bad_files());
}

static void unreadable_files(void **state)
{
    (void)state;
    static const char *const paths[] = {"/no/such/scene.yaml", RY_SOURCE_DIR "/tests/bad", "",
                                        NULL};
    for (int i = 0; paths[i] != NULL; i++) {
        ry_config config;
        ry_error error = {0};
        assert_int_equal(ry_config_load(&config, paths[i], NULL, 0, &error), RY_BAD_FILE);
        assert_non_null(strstr(error.text, paths[i]));
        assert_null(config.text);
    }
    assert_int_equal(ry_config_load(&(ry_config){0}, "/dev/zero", NULL, 0, NULL), RY_BAD_INPUT);
}

static void bad_overrides(void **state)
{
    (void)state;
    bad(BED, "domain.length=3 kg", "-s domain.length=3 kg: domain.length: the unit 'kg'");
    bad(BED, "grains.diametre=1 mm", "did you mean grains.diameter?");
    bad(BED, "fluids.shields=0.3", "did you mean fluid.shields?");
    bad(BED, "fluids.density=1000", "did you mean fluid.density?");
    bad(BED, "stepsize=1 us", "did you mean time.step?");
    bad(BED, "particles=[]", "particles can't be set by -s");
    bad(BED, "particles[0].spin=1", "particles can't be set by -s");
    bad(BED, "particles.spin=1", "particles can't be set by -s");
    bad(BED, "grains={}", "one of its keys");
    bad(BED, "time.step", "section.key=value");
    bad(BED, "=1", "section.key=value");
    bad(BED, "time.step=", "no value");
    bad(BED, "time.step=#", "no value");
    bad(BED, "time.step=[", "not valid YAML");
    bad(BED, "time.step={a: 1}", "a map");
    bad(BED, "time.step=1 us\ntime.end=1", "in one line");
    bad(BED, "title=\xff", "in one line");
    bad(BED, "title=\"a\\0b\"", "NUL");
    bad("{}", "time.end=1", "no grains");
    bad("", "grains.columns=5", "the scene is empty");
}

static void two_keys_for_one_thing(void **state)
{
    (void)state;
    const char *both[] = {"contact.alpha_m=20", "contact.stiffness=50"};
    ry_config config;
    ry_error error = {0};
    assert_int_equal(ry_config_parse(&config, BED, "", both, 2, &error), RY_BAD_INPUT);
    assert_non_null(strstr(error.text, "contradicts contact.alpha_m"));

    /* An override of either replaces what the file says. */
    const char *stiff = BED "contact: {stiffness: 50 N/m}\nfluid: {shear_stress: 1 Pa}\n";
    config = good(stiff, "contact.alpha_m=30");
    assert_true(isnan(config.contact_stiffness) && config.contact_alpha_m == 30.0);
    ry_config_free(&config);
    config = good(stiff, "fluid.shields=0.5");
    assert_true(isnan(config.fluid_shear_stress) && config.fluid_shields == 0.5);
    assert_true(config.contact_stiffness == 50.0);
    ry_config_free(&config);
    config = good(BED "contact: {alpha_m: 30}\nfluid: {shields: 0.1}\n", "fluid.shear_stress=1 Pa");
    assert_true(fabs(config.fluid_shields - 1.0 / (1650.0 * 9.81 * 0.5e-3)) < 1e-15);
    ry_config_free(&config);
}

/* Scenes with bytes changed, removed and doubled: refused or read, but never a crash or a leak. */
static void damaged_scenes(void **state)
{
    (void)state;
    static const char *const files[] = {"flume", "oblique", "three-spheres"};
    static const char odd[] = "{}[]:,-#&*!|>'\"%@` \n\t0e.\\\x01\x7f\xc3\xff";
    uint64_t random = 88172645463325252u;
    for (int i = 0; i < 1500; i++) {
        char path[600], text[8192] = "";
        (void)snprintf(path, sizeof path, "%s/params/%s.yaml", RY_SOURCE_DIR, files[i % 3]);
        const char *scene = read_file(path);
        assert_true(strlen(scene) < sizeof text);
        memcpy(text, scene, strlen(scene));
        const size_t length = strlen(text);
        for (int j = 0; j <= i % 8; j++) {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            const size_t at = (size_t)(random >> 16) % length;
            const size_t from = (size_t)(random >> 40) % length;
            const size_t n = (random & 3) == 0 ? length - at : 1;
            if (random & 4) {
                memmove(text + at, text + from, n < 40 && from + n <= length ? n : 1);
            } else {
                text[at] = odd[from % (sizeof odd - 1)];
            }
        }
        ry_config config;
        ry_error error;
        const ry_status status = parse(&config, text, NULL, &error);
        assert_true(status == RY_OK || (status == RY_BAD_INPUT && error.text[0] != '\0'));
        ry_config_free(&config);
    }
}

/* --- What is read ----------------------------------------------------------------------------- */

static void scenes_of_params_load(void **state)
{
    (void)state;
    int n = 0;
    DIR *folder = opendir(RY_SOURCE_DIR "/params");
    assert_non_null(folder);
    for (const struct dirent *entry; (entry = readdir(folder)) != NULL;) {
        char path[600];
        (void)snprintf(path, sizeof path, "%s/params/%s", RY_SOURCE_DIR, entry->d_name);
        /* Sweeps are read by their own command. */
        if (strstr(path, ".yaml") == NULL || strstr(path, "sweep") != NULL) {
            continue;
        }
        ry_config config, again;
        ry_error error = {0};
        if (ry_config_load(&config, path, NULL, 0, &error) != RY_OK) {
            fail_msg("%s", error.text);
        }
        assert_string_equal(config.path, path);
        assert_string_not_equal(config.title, "");
        again = good(config.text, NULL);
        assert_same(&config, &again);
        ry_config_free(&again);
        ry_config_free(&config);
        n++;
    }
    (void)closedir(folder);
    assert_true(n >= 7);
}

static void quantities(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } lengths[] = {{"0.01", 0.01},          {"10 mm", 0.01},  {"10mm", 0.01},
                   {"'10 mm'", 0.01},       {"1 cm", 0.01},   {"1e4 um", 0.01},
                   {"1e4 \xc2\xb5m", 0.01}, {"+.01 m", 0.01}, {"1.E-2", 0.01},
                   {"1e-5 km", 0.01},       {"7 mm", 0.007},  {"12.3 mm", 0.0123},
                   {"3.3 cm", 0.033}};
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        char text[200];
        (void)snprintf(text, sizeof text, "domain:\n  length: %s\n" BED, lengths[i].text);
        ry_config config = good(text, NULL);
        assert_true(config.domain_length == lengths[i].value);
        ry_config_free(&config);
    }
    ry_config config = good("time: {step: 20 us, end: 1 min, settle: 300 ms}\n"
                            "grains: {density: 2.65 g/cm^3, columns: 5, layers: 2}\n"
                            "domain: {gravity: 981 cm/s^2}\nfluid: {viscosity: 1 mm^2/s}\n",
                            NULL);
    assert_true(config.time_step == 20e-6 && config.time_end == 60.0 && config.time_settle == 0.3);
    assert_true(fabs(config.grains_density - 2650.0) < 1e-9);
    assert_true(config.domain_gravity == 9.81 && config.fluid_viscosity == 1e-6);
    ry_config_free(&config);
}

static void locale_does_not_matter(void **state)
{
    (void)state;
    if (setlocale(LC_NUMERIC, "de_DE.UTF-8") == NULL) {
        skip();
    }
    ry_config config = good(BED "time: {step: 0.02 ms}\n", NULL);
    assert_true(config.time_step == 20e-6);
    ry_config_free(&config);
    (void)setlocale(LC_NUMERIC, "C");
}

static void bed_and_inert_defaults(void **state)
{
    (void)state;
    ry_config bed = good("grains:\n", NULL);
    assert_true(bed.has_grains && bed.grains_columns == 20 && bed.domain_periodic);
    assert_int_equal(bed.domain_floor, RY_FLOOR_ROUGH);
    assert_int_equal(bed.fluid_model, RY_FLUID_BALANCE);
    assert_true(bed.domain_length == 20 * 0.5e-3);
    assert_int_equal(bed.output_fields, RY_FIELD_ALL);
    ry_config_free(&bed);
    ry_config one = good("particles: [{position: [1 mm, 0]}]\n", NULL);
    assert_true(!one.has_grains && !one.domain_periodic && one.domain_gravity == 0.0);
    assert_int_equal(one.domain_floor, RY_FLOOR_NONE);
    assert_int_equal(one.fluid_model, RY_FLUID_NONE);
    assert_true(isnan(one.domain_length));
    ry_config_free(&one);
    ry_config made = good("particles: [{position: [1 mm, 0.1]}]\n", "grains.columns=5");
    assert_true(made.has_grains && made.grains_columns == 5 && made.n_particles == 1);
    assert_int_equal(made.fluid_model, RY_FLUID_BALANCE);
    ry_config_free(&made);
}

static void particles(void **state)
{
    (void)state;
    ry_config config = good("title: 'two: grains'\n"
                            "domain: {periodic: yes, length: 10 mm}\n"
                            "output: {fields: [position, flux]}\n"
                            "particles:\n"
                            "  - position: [-1 mm, 25 um]\n"
                            "    velocity: [1 cm/s, -0.5]\n"
                            "    spin: 30 deg/s\n"
                            "    diameter: 2 mm\n"
                            "    density: 2 g/cm^3\n"
                            "  - {position: [0.015, 5 mm], fixed: true, spin: 2 1/s}\n",
                            NULL);
    assert_string_equal(config.title, "two: grains");
    assert_int_equal(config.output_fields, RY_FIELD_POSITION | RY_FIELD_FLUX);
    assert_int_equal(config.n_particles, 2);
    const ry_particle *a = &config.particles[0], *b = &config.particles[1];
    assert_true(fabs(a->position[0] - 0.009) < 1e-17 && a->position[1] == 25e-6);
    assert_true(a->velocity[0] == 0.01 && a->velocity[1] == -0.5);
    assert_true(fabs(a->spin - 0.52359877559829887) < 1e-15);
    assert_true(a->diameter == 0.002 && fabs(a->density - 2000.0) < 1e-9 && !a->fixed);
    assert_true(fabs(b->position[0] - 0.005) < 1e-17 && b->fixed && b->spin == 2.0);
    assert_true(b->diameter == 0.5e-3 && b->density == 2650.0);
    assert_int_equal(a->line, 5);
    assert_int_equal(b->line, 10);
    ry_config_free(&config);
}

static void overrides_replace_and_stay_in_the_text(void **state)
{
    (void)state;
    static const char *const overrides[] = {"title=other: words", "contact.law=tanaka",
                                            "output.fields=[position, energy]", "time.end=2 min",
                                            " time.end = 3 min"};
    const char *text = "title: words\n" BED "contact: {restitution: 0.5}\n# a comment\n";
    ry_config config, again;
    ry_error error = {0};
    assert_int_equal(ry_config_parse(&config, text, "", overrides, 3, &error), RY_BAD_INPUT);
    error = (ry_error){0};
    assert_int_equal(ry_config_parse(&config, text, "", overrides + 1, 2, &error), RY_OK);
    assert_int_equal(config.contact_law, RY_LAW_TANAKA);
    assert_int_equal(config.output_fields, RY_FIELD_POSITION | RY_FIELD_ENERGY);
    char expected[400];
    (void)snprintf(expected, sizeof expected, "%s\n# -s %s\n# -s %s", text, overrides[1],
                   overrides[2]);
    assert_string_equal(config.text, expected);
    again = good(config.text, NULL);
    assert_same(&config, &again);
    ry_config_free(&again);
    again = good(config.text, "contact.law=energy"); /* the last word counts */
    assert_int_equal(again.contact_law, RY_LAW_ENERGY);
    ry_config third = good(again.text, "contact.law=fujioka-2");
    ry_config fourth = good(third.text, NULL);
    assert_int_equal(fourth.contact_law, RY_LAW_FUJIOKA2);
    assert_same(&third, &fourth);
    ry_config_free(&fourth);
    ry_config_free(&third);
    ry_config_free(&again);
    ry_config_free(&config);
    assert_int_equal(ry_config_parse(&config, text, "", overrides + 3, 2, &error), RY_OK);
    assert_true(config.time_end == 180.0);
    ry_config_free(&config);
}

/* A long list with units, all touching: read and checked in the time of a key press. */
static void many_particles(void **state)
{
    (void)state;
    const int columns = 100, rows = 1000;
    char *text = malloc((size_t)columns * (size_t)rows * 80 + 100), *end = text;
    assert_non_null(text);
    end += sprintf(end, "domain: {periodic: true, length: %d mm}\nparticles:\n", columns);
    for (int i = 0; i < columns * rows; i++) {
        end += sprintf(end, "- {position: [%d mm, %d mm], diameter: 1 mm}\n", i % columns,
                       i / columns);
    }
    ry_config config = good(text, NULL);
    assert_int_equal(config.n_particles, columns * rows);
    ry_config_free(&config);
    free(text);
}

/* --- The library's own configs ---------------------------------------------------------------- */

static void configs_made_by_a_program(void **state)
{
    (void)state;
    ry_error error = {0};
    ry_config zero = {0};
    assert_int_equal(ry_config_resolve(&zero, &error), RY_BAD_INPUT);
    assert_non_null(strstr(error.text, "ry_config_default"));
    ry_config_free(&zero);
    ry_config_free(NULL);

    ry_config config = ry_config_default(1);
    assert_true(config.title != NULL && config.text != NULL && config.path != NULL);
    error = (ry_error){0};
    assert_int_equal(ry_config_resolve(&config, &error), RY_OK);
    ry_config twice = config;
    assert_int_equal(ry_config_resolve(&twice, &error), RY_OK);
    assert_same(&config, &twice);
    config.grains_spread = 0.7;
    assert_int_equal(ry_config_resolve(&config, &error), RY_BAD_INPUT);
    assert_string_equal(error.text, "grains.spread: 0.7 is out of range; allowed is 0 to 0.5");
    config.grains_spread = NAN;
    assert_int_equal(ry_config_resolve(&config, NULL), RY_BAD_INPUT);
    config.grains_spread = 0.1;
    config.contact_law = RY_LAW_COUNT;
    assert_int_equal(ry_config_resolve(&config, NULL), RY_BAD_INPUT);
    ry_config_free(&config);
    ry_config_free(&config);
}

static void the_first_failure_is_kept(void **state)
{
    (void)state;
    ry_error error = {0};
    assert_int_equal(ry_fail(&error, RY_BAD_FILE, "first %d", 1), RY_BAD_FILE);
    assert_int_equal(ry_fail(&error, RY_BAD_INPUT, "second"), RY_BAD_INPUT);
    assert_int_equal(error.status, RY_BAD_FILE);
    assert_string_equal(error.text, "first 1");
    assert_int_equal(ry_fail(NULL, RY_BAD_INPUT, "nobody listens"), RY_BAD_INPUT);
}

static void every_parameter_is_listed(void **state)
{
    (void)state;
    ry_config config = ry_config_default(1);
    ry_parameter p;
    int n = 0, choices = 0;
    for (; ry_config_parameter(&config, n, &p); n++) {
        assert_true(p.text[0] != '\0' && p.section[0] != '\0' && p.key[0] != '\0');
        assert_true(isnan(p.number) || (p.number >= p.low && p.number <= p.high));
        choices += p.type == 'c';
        assert_true((p.type == 'c') == (p.word != NULL));
        assert_true(p.type != 'c' || strcmp(p.word, p.words[(int)p.number]) == 0);
    }
    assert_true(n > 40 && choices == 10);
    assert_false(ry_config_parameter(&config, -1, &p));
    ry_config_free(&config);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_scenes_say_what_is_wrong),
        cmocka_unit_test(unreadable_files),
        cmocka_unit_test(bad_overrides),
        cmocka_unit_test(two_keys_for_one_thing),
        cmocka_unit_test(damaged_scenes),
        cmocka_unit_test(scenes_of_params_load),
        cmocka_unit_test(quantities),
        cmocka_unit_test(locale_does_not_matter),
        cmocka_unit_test(bed_and_inert_defaults),
        cmocka_unit_test(particles),
        cmocka_unit_test(overrides_replace_and_stay_in_the_text),
        cmocka_unit_test(many_particles),
        cmocka_unit_test(configs_made_by_a_program),
        cmocka_unit_test(the_first_failure_is_kept),
        cmocka_unit_test(every_parameter_is_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
