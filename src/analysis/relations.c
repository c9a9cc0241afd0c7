/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The formulas, each with where it comes from. Adding one: a function unless it is a power of the
 * excess stress, a row of the table, a row of tests/data/bedload_relations.csv. */
#include "analysis/relations.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* q* = a (theta - theta_c)^b. */
static double excess_power(const ry_relation *r, const ry_relation_input *in)
{
    return r->a * pow(in->theta - in->theta_c, r->b);
}

/* q* = a (theta - theta_c) (sqrt(theta) - b sqrt(theta_c)). Ashida & Michiue 1972 (Proc. JSCE 206,
 * 59) print 17 theta_e^1.5 (1 - theta_c/theta) (1 - sqrt(theta_c/theta)), which is this with b = 1
 * where the whole stress acts on the grains, theta_e = theta: a plane bed. Engelund & Fredsoe 1976
 * (Nordic Hydrol. 7, 293) with b = 0.7: what their next relation tends to just above the threshold,
 * a = 30/(0.51 pi) = 18.72, printed 18.74. */
static double excess_velocity(const ry_relation *r, const ry_relation_input *in)
{
    return r->a * (in->theta - in->theta_c) * (sqrt(in->theta) - r->b * sqrt(in->theta_c));
}

/* Engelund & Fredsoe 1976: q* = 5 p (sqrt(theta) - 0.7 sqrt(theta_c)), with the share of moving
 * grains in the top layer p = (1 + (pi/6 b/(theta - theta_c))^4)^(-1/4), b their dynamic friction. */
static double engelund_fredsoe_share(const ry_relation *r, const ry_relation_input *in)
{
    const double pi = 3.14159265358979323846;
    const double ratio = pi / 6.0 * r->b / (in->theta - in->theta_c);
    const double p = pow(1.0 + pow(ratio, 4.0), -0.25);
    return r->a * p * (sqrt(in->theta) - 0.7 * sqrt(in->theta_c));
}

/* Einstein 1942 (Trans. ASCE 107, 561): 0.465 q* = F exp(-0.391/theta), with Rubey's F, 0.816 for coarse grains; as
 * it is usually given, F = 1. */
static double einstein_exponential(double theta)
{
    return exp(-0.391 / theta) / 0.465;
}

static double einstein(const ry_relation *r, const ry_relation_input *in)
{
    (void)r;
    return einstein_exponential(in->theta);
}

/* Brown 1950 (in Engineering Hydraulics, ed. Rouse, p. 769): Einstein's curve for weak transport,
 * q* = 40 F theta^3 above, both times Rubey's dimensionless fall velocity F. */
static double einstein_brown(const ry_relation *r, const ry_relation_input *in)
{
    const double g = 36.0 / (in->d_star * in->d_star * in->d_star);
    const double fall = sqrt(2.0 / 3.0 + g) - sqrt(g);
    if (in->theta < r->b) {
        return fall * einstein_exponential(in->theta);
    }
    return fall * r->a * in->theta * in->theta * in->theta;
}

/* Yalin 1963 (J. Hydraul. Div. ASCE 89, HY3, 221): q* = 0.635 sqrt(theta) e (1 - ln(1 + k e)/(k e)),
 * e = theta/theta_c - 1, k = 2.45 sqrt(theta_c)/s^0.4. */
static double yalin(const ry_relation *r, const ry_relation_input *in)
{
    const double e = in->theta / in->theta_c - 1.0;
    const double ke = 2.45 * sqrt(in->theta_c) / pow(in->s, 0.4) * e;
    return r->a * sqrt(in->theta) * e * (1.0 - log1p(ke) / ke);
}

/* Nielsen 1992 (Coastal Bottom Boundary Layers, p. 112): q* = 12 sqrt(theta) (theta - theta_c). */
static double nielsen(const ry_relation *r, const ry_relation_input *in)
{
    return r->a * sqrt(in->theta) * (in->theta - in->theta_c);
}

/* Camenen & Larson 2005 (Estuar. Coast. Shelf Sci. 63, 249): q* = 12 theta^1.5 exp(-4.5 theta_c/theta);
 * no grain is said to rest for sure, the threshold only bends the curve. */
static double camenen_larson(const ry_relation *r, const ry_relation_input *in)
{
    return r->a * pow(in->theta, 1.5) * exp(-r->b * in->theta_c / in->theta);
}

/* Cheng 2002 (J. Hydraul. Eng. 128, 942): q* = 13 theta^1.5 exp(-0.05/theta^1.5). */
static double cheng(const ry_relation *r, const ry_relation_input *in)
{
    const double power = pow(in->theta, 1.5);
    return r->a * power * exp(-r->b / power);
}

/* Parker 1979 (J. Hydraul. Div. ASCE 105, HY9, 1185): q* = 11.2 (theta - 0.03)^4.5/theta^3. */
static double parker(const ry_relation *r, const ry_relation_input *in)
{
    return r->a * pow(in->theta - in->theta_c, r->b) / (in->theta * in->theta * in->theta);
}

/* Paehtz & Duran 2020 (Phys. Rev. Lett. 124, 168001): q* = a e (1 + 1.7/0.63 e), e = theta - theta_c,
 * a = 2 sqrt(theta_c)/(0.4 x 0.63): von Karman's constant and the bed friction coefficient. */
static double paehtz_duran(const ry_relation *r, const ry_relation_input *in)
{
    const double karman = 0.4, friction = 0.63;
    const double e = in->theta - in->theta_c;
    return r->a * sqrt(in->theta_c) / (karman * friction) * e * (1.0 + r->b / friction * e);
}

static const ry_relation relations[] = {
    {"meyer-peter-muller", "Meyer-Peter & Müller", "8 (θ - 0.047)^1.5", 1948, 0.047, 8.0, 1.5, excess_power},
    {"wong-parker", "Wong & Parker", "3.97 (θ - 0.0495)^1.5", 2006, 0.0495, 3.97, 1.5, excess_power},
    {"wong-parker-1.6", "Wong & Parker", "4.93 (θ - 0.047)^1.6", 2006, 0.047, 4.93, 1.6, excess_power},
    {"ashida-michiue", "Ashida & Michiue", "17 (θ - θc) (√θ - √θc); θc = 0.05", 1972, 0.05, 17.0, 1.0,
     excess_velocity},
    {"engelund-fredsoe", "Engelund & Fredsøe", "18.74 (θ - θc) (√θ - 0.7 √θc); θc = 0.05", 1976, 0.05, 18.74,
     0.7, excess_velocity},
    {"engelund-fredsoe-share", "Engelund & Fredsøe",
     "5 p (√θ - 0.7 √θc); p = (1 + (π/6 × 0.51/(θ - θc))^4)^(-1/4); θc = 0.05", 1976, 0.05, 5.0, 0.51,
     engelund_fredsoe_share},
    {"fernandez-luque-van-beek", "Fernandez Luque & van Beek", "5.7 (θ - 0.045)^1.5", 1976, 0.045, 5.7, 1.5,
     excess_power},
    {"einstein-brown", "Einstein & Brown", "40 F θ³; F exp(-0.391/θ)/0.465 for θ < 0.18", 1950, 0.0, 40.0,
     0.18, einstein_brown},
    {"einstein", "Einstein", "exp(-0.391/θ)/0.465", 1942, 0.0, 0.0, 0.0, einstein},
    {"wilson", "Wilson", "12 (θ - 0.047)^1.5", 1966, 0.047, 12.0, 1.5, excess_power},
    {"yalin", "Yalin",
     "0.635 √θ e (1 - ln(1 + k e)/(k e)); e = θ/θc - 1; k = 2.45 √θc/s^0.4; θc = 0.047", 1963, 0.047, 0.635,
     0.0, yalin},
    {"nielsen", "Nielsen", "12 √θ (θ - 0.05)", 1992, 0.05, 12.0, 0.0, nielsen},
    {"ribberink", "Ribberink", "11 (θ - 0.05)^1.65", 1998, 0.05, 11.0, 1.65, excess_power},
    {"camenen-larson", "Camenen & Larson", "12 θ^1.5 exp(-4.5 θc/θ); θc = 0.05", 2005, 0.05, 12.0, 4.5,
     camenen_larson},
    {"cheng", "Cheng", "13 θ^1.5 exp(-0.05/θ^1.5)", 2002, 0.0, 13.0, 0.05, cheng},
    {"parker", "Parker", "11.2 (θ - 0.03)^4.5/θ³", 1979, 0.03, 11.2, 4.5, parker},
    {"huang", "Huang", "6 (θ - 0.047)^(5/3)", 2010, 0.047, 6.0, 5.0 / 3.0, excess_power},
    {"hunziker-jaeggi", "Hunziker & Jaeggi", "5 (θ - 0.05)^1.5", 2002, 0.05, 5.0, 1.5, excess_power},
    {"paehtz-duran", "Pähtz & Durán", "2 √θc/(0.4 × 0.63) e (1 + 1.7/0.63 e); e = θ - θc; θc = 0.05", 2020,
     0.05, 2.0, 1.7, paehtz_duran},
};

int ry_relation_count(void)
{
    return (int)(sizeof relations / sizeof *relations);
}

const ry_relation *ry_relation_at(int index)
{
    return index >= 0 && index < ry_relation_count() ? &relations[index] : NULL;
}

const ry_relation *ry_relation_find(const char *key)
{
    for (int i = 0; i < ry_relation_count(); i++) {
        if (strcmp(relations[i].key, key) == 0) {
            return &relations[i];
        }
    }
    return NULL;
}

double ry_relation_flux_of(const ry_relation *relation, const ry_relation_input *input)
{
    ry_relation_input in = *input;
    if (isnan(in.theta_c)) {
        in.theta_c = relation->theta_c;
    }
    const int bends_only = relation->flux == camenen_larson; /* its threshold stops nothing */
    if (!(in.theta > 0.0) || (!bends_only && in.theta <= in.theta_c)) {
        return isnan(in.theta) ? in.theta : 0.0;
    }
    return relation->flux(relation, &in);
}

double ry_relation_flux(const ry_relation *relation, double theta)
{
    const ry_relation_input in = {.theta = theta, .theta_c = NAN, .s = 2.65, .d_star = 150.0};
    return ry_relation_flux_of(relation, &in);
}

double ry_relation_d_star(double diameter, double s, double gravity, double viscosity)
{
    return diameter * cbrt((s - 1.0) * gravity / (viscosity * viscosity));
}

/* Soulsby & Whitehouse 1997 (Proc. Pacific Coasts and Ports, 149); Soulsby 1997, eq. 77. */
static double soulsby_whitehouse(double d_star)
{
    return 0.30 / (1.0 + 1.2 * d_star) + 0.055 * (1.0 - exp(-0.020 * d_star));
}

/* Iwagaki 1956 (Trans. JSCE 41, 1): five pieces in R* = sqrt((s - 1) g d^3)/nu. */
static double iwagaki(double d_star)
{
    const double r = pow(d_star, 1.5);
    if (r <= 2.14) {
        return 0.14;
    }
    if (r <= 54.2) {
        return 0.195 * pow(r, -7.0 / 16.0);
    }
    if (r <= 162.7) {
        return 0.034;
    }
    if (r <= 671.0) {
        return 0.00849 * pow(r, 3.0 / 11.0);
    }
    return 0.05;
}

/* Brownlie 1981 (Caltech report KH-R-43A): a fit to Shields' curve, with Y = R*^-0.6. */
static double brownlie(double d_star)
{
    const double y = pow(d_star, -0.9);
    return 0.22 * y + 0.06 * pow(10.0, -7.7 * y);
}

static const ry_threshold thresholds[] = {
    {"soulsby-whitehouse", "Soulsby & Whitehouse", "0.30/(1 + 1.2 D*) + 0.055 (1 - exp(-0.020 D*))", 1997,
     soulsby_whitehouse},
    {"iwagaki", "Iwagaki",
     "R* = D*^1.5; 0.14 to R* = 2.14; 0.195 R*^(-7/16) to 54.2; 0.034 to 162.7; 0.00849 R*^(3/11) to 671; 0.05",
     1956, iwagaki},
    {"brownlie", "Brownlie", "0.22 Y + 0.06 × 10^(-7.7 Y); Y = D*^-0.9", 1981, brownlie},
};

int ry_threshold_count(void)
{
    return (int)(sizeof thresholds / sizeof *thresholds);
}

const ry_threshold *ry_threshold_at(int index)
{
    return index >= 0 && index < ry_threshold_count() ? &thresholds[index] : NULL;
}

const ry_threshold *ry_threshold_find(const char *key)
{
    for (int i = 0; i < ry_threshold_count(); i++) {
        if (strcmp(thresholds[i].key, key) == 0) {
            return &thresholds[i];
        }
    }
    return NULL;
}
