/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * docs/parameters.md, from the one list of parameters. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/cli.h"

static void print_value(const ry_parameter *p)
{
    if (p->type == 'c') {
        printf("%s", p->word);
    } else if (p->type == 'f') {
        printf("%s", p->number != 0 ? "true" : "false");
    } else if (isnan(p->number)) {
        printf("not set");
    } else {
        printf("%.10g", p->number);
    }
}

static int is_same_value(const ry_parameter *a, const ry_parameter *b)
{
    return a->number == b->number || (isnan(a->number) && isnan(b->number));
}

static void print_allowed(const ry_parameter *p)
{
    if (p->type == 'c') {
        for (int i = 0; p->words[i]; i++) {
            printf("%s%s", i ? ", " : "", p->words[i]);
        }
    } else if (p->type == 'f') {
        printf("true, false");
    } else {
        printf("%.10g ... %.10g", p->low, p->high);
    }
}

static void print_row(const ry_parameter *p, const ry_parameter *inert)
{
    printf("| `%s` | ", p->key);
    print_value(p);
    if (!is_same_value(p, inert)) {
        printf(" (");
        print_value(inert);
        printf(")");
    }
    printf(" | %s | ", strcmp(p->unit, "1") == 0 ? "" : p->unit);
    print_allowed(p);
    printf(" | %s |\n", p->text);
}

static void print_head(void)
{
    printf(
        "# Parameters of a scene\n\n"
        "Made by `ryusa show --parameters` (`make docs`); don't edit.\n\n"
        "A scene file is YAML. A value may carry a unit (`0.5 mm`, `20 us`, `2650 kg/m^3`); a bare number "
        "is SI. On\nthe command line `-s section.key=value` replaces a value, or gives one that the scene lacks "
        "(one of `grains` makes a bed).\nLines `# -s section.key=value` at the end of a scene count, too: so results "
        "and `ryusa tune` keep them. A default in\nbrackets holds for a scene that has `particles` but no section "
        "`grains`. *not set*: follows from others or is left out, see\nthe meaning; `ryusa show SCENE.yaml` prints what "
        "came out.\n\n"
        "`title:` at the top is any text.\n");
}

static void print_tail(void)
{
    printf(
        "\n## output.fields\n\nA list; all of them unless given. What is not asked for is not computed.\n\n"
        "| word | meaning |\n|---|---|\n");
#define RY_FIELD(bit, word, text) printf("| `%s` | %s |\n", word, text);
    RY_LIST_field(RY_FIELD)
#undef RY_FIELD
    printf(
        "\n## particles\n\nA list of explicit grains, beside or instead of `grains`:\n\n"
        "    particles:\n"
        "      - {position: [1 mm, 2 mm], velocity: [0, -0.1 m/s], spin: 0, diameter: 0.5 mm,\n"
        "         density: 2650 kg/m^3, fixed: false}\n\n"
        "`position` (x, z) is needed. `velocity` and `spin` (positive from z towards x) are zero, "
        "`diameter` and\n`density` those of `grains`, `fixed` false unless given. At the start a grain may "
        "lie in another, the\nfloor or a wall by a twentieth of the smaller "
        "diameter: those of a bed at rest, or of one that flows, do.\n\n"
        "Many grains are better kept in a table (CSV), which is read ten times as fast:\n\n"
        "    particles:\n"
        "      - {file: grains.csv, density: 2650 kg/m^3}     # all others of one grain, too, but position\n\n"
        "Its path begins in the folder of the scene. Its first line names the columns: `x` and `z`, and as wanted `vx`, `vz`,\n"
        "`spin`, `diameter`, `density`, `fixed` (0 or 1), in any order; `x [mm]` has a unit other than SI. What it has no column "
        "for\nis the same for all its grains. Empty lines and those that begin with `#` are skipped. The numbers are kept in the\n"
        "result (`/parameters/particles`, with these names of columns).\n");
}

void ry_cli_print_parameters(void)
{
    ry_config with = ry_config_default(1), without = ry_config_default(0);
    ry_parameter p, inert;
    char section[64] = "";
    print_head();
    for (int i = 0; ry_config_parameter(&with, i, &p) && ry_config_parameter(&without, i, &inert);
         i++) {
        if (strcmp(section, p.section) != 0) {
            snprintf(section, sizeof section, "%s", p.section);
            printf(
                "\n## %s\n\n| key | default | unit | allowed | meaning |\n|---|---|---|---|---|\n",
                section);
        }
        print_row(&p, &inert);
    }
    print_tail();
    ry_config_free(&with);
    ry_config_free(&without);
}
