"""Templates of the exported C: header and source, with the regressor and the feed-forward where an axis has them."""

HEADER = """\
/* Axis {name}, exported by symid. {measured_line}
 *
{notes}
 */
#ifndef {guard}
#define {guard}
#ifdef __cplusplus
extern "C" {{
#endif
#ifndef SYMID_REAL
#define SYMID_REAL double /* the type of all numbers; -DSYMID_REAL=float for single precision */
#endif

enum {{
    {name}_bodies = {bodies},         /* displacements in a state x: all displacements, then all velocities */
    {name}_states = {n_state},{memory}{regressor_sizes}
    {name}_readings = {n_sensors}
}};

/* Physical parameters. */
typedef struct {{
{members}
}} {name}_parameters;

/* The values of the export. */
extern const {name}_parameters {name}_values;

{regressor_header}/* dx = f(x, {force}) of the state x = {{{state}}}:
 * displacements of the bodies against the ground (of one on a geared body: against that), then velocities. */
void {name}_derivative(const {name}_parameters *p, const double x[{n_state}], {forces}, double dx[{n_state}]);

/* Advance the state x by h under a constant {force}. Friction sticks and breaks loose; of first order in h. */
void {name}_step(const {name}_parameters *p, double x[{n_state}], {forces}, double h);

/* Readings of the sensors, y = {{{sensors}}}; dx is what {name}_derivative gave. */
void {name}_sensors(const double x[{n_state}], const double dx[{n_state}], double y[{n_sensors}]);

{feedforward_header}{settle_header}{way_header}
#ifdef __cplusplus
}}
#endif
#endif
"""

C_SOURCE = """\
#include <math.h>
#include "{header}"

/* Speed below which friction is a straight line through 0; 0 is the law as it was identified. */
#ifndef SYMID_REST_SPEED
#define SYMID_REST_SPEED 0.0
#endif

{constants}const {name}_parameters {name}_values = {{
{values}
}};

static inline double sign(double v)
{{
    const double rest = SYMID_REST_SPEED;
    return v > rest ? 1.0 : v < -rest ? -1.0 : rest > 0.0 ? v/rest : 0.0;
}}

static inline double positive(double v)
{{
    const double rest = SYMID_REST_SPEED;
    return v > rest ? 1.0 : v > -rest && rest > 0.0 ? (1.0 + v/rest)/2.0 : 0.0;
}}

{regressor_source}\
void {name}_derivative(const {name}_parameters *p, const double x[{n_state}], {forces}, double dx[{n_state}])
{{
{derivative}
}}

{step}
void {name}_sensors(const double x[{n_state}], const double dx[{n_state}], double y[{n_sensors}])
{{
{readings}
}}
{feedforward_source}{settle_source}{way_source}"""

REGRESSOR_SIZES = """
    {name}_signals = {n_signals},
    {name}_equations = {equations},
    {name}_minimal = {n_minimal},"""

REGRESSOR_HEADER = """\
/* Regressor W and output y of the minimal model, y = W X, for
 * signals = {{{signals}}}. */
void {name}_regressor(const double signals[], double W[{equations}][{n_minimal}]);
void {name}_output(const double signals[], double y[{equations}]);

/* Minimal parameters X = {{{minimal}}}. */
void {name}_minimal_parameters(const {name}_parameters *p, double X[{n_minimal}]);

"""

REGRESSOR_SOURCE = """\
void {name}_regressor(const double signals[], double W[{equations}][{n_minimal}])
{{
{regressor}
}}

void {name}_output(const double signals[], double y[{equations}])
{{
{output}
}}

void {name}_minimal_parameters(const {name}_parameters *p, double X[{n_minimal}])
{{
{forward}
}}

"""

FEEDFORWARD_HEADER = """\
/* Force that a motion of the drive needs: no feedback, no deflection of springs. Give it the reference. */
double {name}_feedforward(const {name}_parameters *p, double position_, double velocity_, double acceleration_);

"""

FEEDFORWARD_SOURCE = """\

double {name}_feedforward(const {name}_parameters *p, double position_, double velocity_, double acceleration_)
{{
    (void)p, (void)position_, (void)velocity_, (void)acceleration_;
{body}
}}
"""

SETTLE_HEADER = """\
/* Before the first step: puts the lags in the state x where they are after a long time under constant {force}. */
void {name}_settle(const {name}_parameters *p, double x[{n_state}], {forces});

"""

SETTLE_SOURCE = """\

void {name}_settle(const {name}_parameters *p, double x[{n_state}], {forces})
{{
{body}
}}
"""
