/* What lies ahead says of a change of speed, in C (AX-609).  Twin: motion.timing.foresight.Foresight, whose words explain what is done.
 *
 *   ahead(columns, places, dt, h, most_u, most_c, probe) -> ahead
 *   step(ahead, rows, low, end, first, past, inverse, foreseen, steady, tau, omega, u, wanted, turns) -> (c, room, wanted rows)
 *       rows: of a window of the track, (parts, columns, rows), in one run of memory: row `low` of the track and those behind it up to
 *       `end`, which hold for those before and behind, too.  Where rows before `first` or from `past` on are needed the first and the last
 *       one of them are answered, and nothing else is done; else None.
 *       foreseen: u at the places; it becomes what is foreseen in the next period.
 *   most(rows, omega, left, u) -> (u, c)
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { REACH, BEND, PULL, LEAN, MEAN, TWIST, PARTS };
#define CALM 0.4
#define HEAVY 4.0
#define RESERVE 0.02
#define TRUST 0.5
#define SPARE 1.05
#define AMPLE 1.3
#define BOLD 0.4
#define USEFUL 0.75
#define STIFF 0.8
#define BEYOND 1.5
#define SLOWEST 0.01
#define LITTLE 1e-6
#define TRIED 5 /* most v tried for the landing */
static const double SHARES[] = {0.25, 0.5, 0.75, 1.0};
static const double LESS[2][2] = {{0.02, 0.935}, {0.005, 0.95}}; /* while omega rises, while it falls */

struct ahead {
    int columns, places;
    double dt, h, most_u, most_c, probe;
    /* (columns,): of the present place */
    double *gain0, *pull0, *rises0, *falls0;
    /* (places,) */
    double *omega, *v, *lowest, *middle, *taus, *middles, *idle, *foot, *rises, *falls, *rise_by, *fall_by, *scale, *sum, *base, *way;
    double *used[2];
    /* (columns, places) */
    double *leans, *risen, *fallen;
    double memory[];
};

static const char AHEAD[] = "axisgate.ahead";

/* As numpy: what is no number stays none. */
static inline double least(double a, double b)
{
    return a < b || a != a ? a : b;
}

static inline double greatest(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double between(double low, double x, double high)
{
    return greatest(least(x, high), low);
}

static void free_ahead(PyObject *capsule)
{
    free(PyCapsule_GetPointer(capsule, AHEAD));
}

static PyObject *make_ahead(PyObject *module, PyObject *arguments)
{
    int columns, places;
    double dt, h, most_u, most_c, probe;
    if (!PyArg_ParseTuple(arguments, "iiddddd", &columns, &places, &dt, &h, &most_u, &most_c, &probe))
        return NULL;
    if (columns < 1 || places < 3)
        return PyErr_Format(PyExc_ValueError, "%d columns, %d places", columns, places);
    struct ahead *a = calloc(1, sizeof *a + sizeof(double) * (4 * (size_t)columns + (18 + 3 * (size_t)columns) * (size_t)places));
    if (!a)
        return PyErr_NoMemory();
    *a = (struct ahead){.columns = columns, .places = places, .dt = dt, .h = h, .most_u = most_u, .most_c = most_c, .probe = probe};
    double *next = a->memory;
    double **small[] = {&a->gain0, &a->pull0, &a->rises0, &a->falls0};
    double **of_places[] = {&a->omega, &a->v,    &a->lowest, &a->middle,  &a->taus,    &a->middles, &a->idle, &a->foot, &a->rises, &a->falls,
                            &a->base, &a->way,    &a->rise_by, &a->fall_by, &a->scale,   &a->sum,  &a->used[0], &a->used[1]};
    double **big[] = {&a->leans, &a->risen, &a->fallen};
    for (size_t k = 0; k < sizeof small / sizeof *small; k++, next += columns)
        *small[k] = next;
    for (size_t k = 0; k < sizeof of_places / sizeof *of_places; k++, next += places)
        *of_places[k] = next;
    for (size_t k = 0; k < sizeof big / sizeof *big; k++, next += (size_t)columns * places)
        *big[k] = next;
    for (int braking = 0; braking < 2; braking++)
        for (int k = 0; k < places; k++)
            a->used[braking][k] = greatest(1.0 - LESS[braking][0] * dt / h * k, LESS[braking][1]);
    PyObject *capsule = PyCapsule_New(a, AHEAD, free_ahead);
    if (!capsule)
        free(a);
    return capsule;
}

/* From each place to the middle of the time its c holds. */
static inline double half(const struct ahead *a, int k)
{
    return k ? 0.5 * a->dt : 0.5 * a->h;
}

/* omega from u, or times from omega: trapezoids from the first place on. */
static void summed(const struct ahead *a, const double *rates, double *sums)
{
    double width = 0.5 * a->dt;
    sums[0] = 0.0;
    for (int k = 1; k < a->places; k++)
        sums[k] = sums[k - 1] + (rates[k - 1] + rates[k]) * width;
}

struct rows {
    const double *first;
    Py_ssize_t part, size; /* doubles from part to part, from column to column */
    int64_t low, end;
};

static inline const double *row(const struct rows *rows, int part, double tau, double inverse)
{
    int64_t at = (int64_t)(tau * inverse);
    at = (at < rows->end ? at : rows->end - 1) - rows->low;
    return rows->first + part * rows->part + (at > 0 ? at : 0);
}

/* Lowest v by the accelerations. */
static void braked(const struct ahead *a, const struct rows *rows, double inverse, double flip, int braking)
{
    double most = a->most_u * (braking ? 1.0 : CALM);
    for (int k = 0; k < a->places; k++) {
        const double *reach = row(rows, REACH, a->taus[k], inverse), *bend = row(rows, BEND, a->taus[k], inverse);
        double square = flip * (a->omega[k] * a->omega[k]), bound = most;
        for (int n = 0; n < a->columns; n++, reach += rows->size, bend += rows->size)
            bound = least(*bend * square + *reach, bound);
        a->lowest[k] = -bound;
    }
}

/* How far c may rise and fall with v = 0 (idle, foot), then with the v foreseen (rises, falls). */
static void reach(const struct ahead *a, const struct rows *rows, double inverse, double flip, int braking)
{
    for (int k = 0; k < a->places; k++) {
        const double *pulls = row(rows, PULL, a->middles[k], inverse), *leans = row(rows, LEAN, a->middles[k], inverse);
        const double *twists = row(rows, k ? MEAN : TWIST, a->middles[k], inverse);
        double middle = a->middle[k], cube = flip * middle * middle * middle, v = a->v[k], used = a->used[braking][k];
        double idle = a->most_c, foot = a->most_c, rises = a->most_c, falls = a->most_c;
        for (int n = 0; n < a->columns; n++, pulls += rows->size, leans += rows->size, twists += rows->size) {
            double lean = *leans * middle, gain = lean * half(a, k) + 1.0; /* c changes v, and v the jerk, while it lasts */
            double pull = *pulls * used / fabs(gain), steady = *twists * cube / gain;
            lean = lean * v / gain;
            double up = pull - steady, down = pull + steady, rise = up - lean, fall = down + lean;
            Py_ssize_t at = (Py_ssize_t)n * a->places + k;
            a->leans[at] = lean, a->risen[at] = rise, a->fallen[at] = fall;
            idle = least(up, idle), foot = least(down, foot), rises = least(rise, rises), falls = least(fall, falls);
            if (!k)
                a->gain0[n] = gain, a->pull0[n] = pull, a->rises0[n] = rise, a->falls0[n] = fall;
        }
        a->idle[k] = idle, a->foot[k] = foot, a->rises[k] = rises, a->falls[k] = falls;
    }
}

/* What c may be at the present place, by the axes whose gain or pull says so alone; by all of them where there are none. */
static void use(const struct ahead *a, int by_gain, double bound)
{
    double rises = INFINITY, falls = INFINITY;
    int any = 0;
    for (int n = 0; n < a->columns; n++)
        if (by_gain ? a->gain0[n] > bound : a->pull0[n] <= bound) {
            rises = least(a->rises0[n], rises), falls = least(a->falls0[n], falls);
            any = 1;
        }
    if (any)
        a->rises[0] = least(rises, a->most_c), a->falls[0] = least(falls, a->most_c);
}

/* Raises the lowest v to what the jerks bear; free_[k] and room are idle + foot and rises + falls. */
static void edge(const struct ahead *a, const double *room, const double *unbent)
{
    for (int k = 0; k < a->places; k++) {
        double v = a->v[k], above = a->most_c, below = a->most_c;
        double bound = v * unbent[k] / greatest(unbent[k] - room[k], LITTLE);
        double further = greatest(least(bound, 0.0), -a->most_u) / v - 1.0; /* beyond the v foreseen the chord is not safe */
        for (int n = 0; n < a->columns; n++) {
            Py_ssize_t at = (Py_ssize_t)n * a->places + k;
            double more = a->leans[at] * further;
            above = least(a->risen[at] - more, above), below = least(a->fallen[at] + more, below);
        }
        if (further > 0.0 && above + below < 0.0)
            bound = v * (1.0 + further * room[k] / greatest(room[k] - (above + below), LITTLE));
        a->lowest[k] = greatest(a->lowest[k], least(bound, 0.0));
    }
}

/* 0, or -1 with an exception. */
static int turned(const struct ahead *a, PyObject *turns, double flip, int braking)
{
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < a->places; k++)
        low = least(a->taus[k], low), high = greatest(a->taus[k], high);
    Py_ssize_t first = 0, count = PyList_GET_SIZE(turns);
    for (Py_ssize_t after = count; first < after;) { /* the first one not before low */
        Py_ssize_t middle = (first + after) / 2;
        double tau = PyFloat_AsDouble(PyTuple_GET_ITEM(PyList_GET_ITEM(turns, middle), 0));
        if (tau < low)
            first = middle + 1;
        else
            after = middle;
    }
    for (; first < count; first++) {
        double tau, jerk, lowest, highest;
        if (!PyArg_ParseTuple(PyList_GET_ITEM(turns, first), "dddd", &tau, &jerk, &lowest, &highest))
            return -1;
        if (tau >= high)
            break;
        for (int k = 0; k + 1 < a->places; k++) {
            double before = a->taus[k] - tau, after = a->taus[k + 1] - tau;
            if (!(before * after <= 0.0))
                continue;
            double share = before != after ? before / (before - after) : 0.0;
            double w = fabs(a->omega[k] + share * (a->omega[k + 1] - a->omega[k]));
            double bound = a->used[braking][k + 1] * jerk / greatest(w, SLOWEST) + w * w * (flip > 0.0 ? lowest : -highest);
            bound = least(-bound, 0.0);
            a->lowest[k] = greatest(a->lowest[k], bound), a->lowest[k + 1] = greatest(a->lowest[k + 1], bound);
        }
    }
    return 0;
}

/* v rises by (rises + slope * (seen v - v)) * dt from place to place. */
static void risen(const struct ahead *a, const double *slope)
{
    a->scale[0] = 1.0, a->sum[0] = 0.0;
    for (int k = 0; k + 1 < a->places; k++) {
        double taken = a->dt * slope[k], kept = between(-STIFF, taken, STIFF);
        double share = STIFF / greatest(taken, STIFF); /* stiffer: v comes near where it rises no more, not beyond */
        a->scale[k + 1] = a->scale[k] * (1.0 - kept);
        a->sum[k + 1] = a->sum[k] + (a->dt * a->rises[k] * share + kept * a->v[k]) / a->scale[k + 1];
    }
}

/* v at place k > 0 when it rises as fast as the jerks allow from v at place 1; 0 once it is reached. */
static inline double back(const struct ahead *a, int k, double v)
{
    return least((a->sum[k] - a->sum[1] + v / a->scale[1]) * a->scale[k], 0.0);
}

/* omega lost from v0 now, v a place further, and behind it. */
static double lost(const struct ahead *a, double v0, double v)
{
    double sum = 0.0;
    for (int k = 1; k < a->places; k++)
        sum += back(a, k, v);
    return -a->dt * (sum - 0.5 * back(a, 1, v)) - 0.5 * a->dt * (v0 + v);
}

/* The lowest v after this period from which the wanted omega is not overshot; 1: it decides the way on, too. */
static int landing(const struct ahead *a, double left, double v0, double lowest, double highest, double *found)
{
    double way = lost(a, v0, lowest), tried[TRIED];
    int count = 4;
    *found = lowest;
    if (way <= left)
        return 0;
    for (int k = 0; k < 4; k++)
        tried[k] = lowest + SHARES[k] * greatest(highest - lowest, 0.0);
    if (lowest < 0.0 && 0.0 < highest) { /* behind v = 0 nothing more is gained: a chord over that place would rest short of it */
        for (int k = 0; k < 4; k++)
            tried[k] = lowest * (1.0 - SHARES[k]);
        tried[count++] = highest;
    }
    for (int k = 0; k < count; k++) {
        double before = way;
        way = lost(a, v0, tried[k]);
        if (way <= left) {
            *found += (tried[k] - *found) * (before - left) / (before - way);
            break;
        }
        *found = tried[k];
    }
    return 1;
}

/* From v0 down to the lowest v from which all behind can be met (base, in v of place 0), and along it. */
static void down(const struct ahead *a, double v0)
{
    double most = -INFINITY, sum = 0.0;
    for (int k = a->places - 1; k >= 0; k--) {
        most = greatest(a->base[k], most);
        a->way[k] = least((most + a->sum[k]) * a->scale[k], 0.0);
    }
    most = -INFINITY;
    for (int k = 0; k < a->places; k++) {
        most = greatest(k ? a->way[k] - sum * a->dt : v0, most);
        a->way[k] = most + sum * a->dt;
        sum += a->falls[k];
    }
}

/* The way as it is seen a period later. */
static void keep(const struct ahead *a, double *seen, double flip)
{
    double now = flip * a->way[0], next = flip * a->way[1], most = greatest(BEYOND * a->most_u, fabs(now));
    for (int k = 0; k < a->places; k++)
        seen[k] = between(-most, (seen[k] + flip * a->way[k]) * TRUST, most);
    seen[0] = now, seen[1] = next;
    if (a->dt == a->h) {
        memmove(seen, seen + 1, sizeof *seen * (size_t)(a->places - 1));
        seen[a->places - 1] = 0.0;
    } else
        for (int k = 0; k + 1 < a->places; k++)
            seen[k] += a->h / a->dt * (seen[k + 1] - seen[k]);
}

struct state {
    double tau, w, u, wanted;
    int steady;
};

/* omega, times of the places and of the middles between them. */
static void places(struct ahead *a, const double *seen, const struct state *now, double flip, int braking)
{
    double low = least(now->w, now->wanted), high = greatest(now->w, now->wanted);
    summed(a, seen, a->omega);
    for (int k = 0; k < a->places; k++) {
        a->omega[k] = between(low, (braking ? a->omega[k] : a->omega[k] * AMPLE) + now->w, high);
        a->v[k] = flip * seen[k];
    }
    summed(a, a->omega, a->taus);
    for (int k = 0; k < a->places; k++) {
        a->middles[k] = a->omega[k] * half(a, k) + a->taus[k] + now->tau;
        a->taus[k] += now->tau;
    }
}

/* c and the room for it; 0, or -1 with an exception. */
static int found(struct ahead *a, const struct rows *rows, double inverse, double *seen, const struct state *now, PyObject *turns, double flip,
                 int braking, double *c, double *room_next)
{
    double v0 = a->v[0], foreseen = a->v[1], dt = a->dt, *room = a->rise_by, *unbent = a->fall_by;
    for (int k = 0; k < a->places; k++) {
        double lower = least(a->v[k], -a->probe);
        a->v[k] = v0 > 0.0 && a->v[k] > 0.0 ? a->v[k] : lower;
        a->middle[k] = a->omega[k] + flip * half(a, k) * a->v[k];
    }
    braked(a, rows, inverse, flip, braking);
    reach(a, rows, inverse, flip, braking);
    double *slope = a->idle, tight = INFINITY;
    for (int n = 0; n < a->columns; n++)
        tight = least(a->pull0[n], tight);
    double share = 0.0 >= v0 && v0 > a->v[0] ? v0 / a->v[0] : 1.0, falls0 = a->falls[0], foot0 = a->foot[0];
    if (0.0 >= v0 && v0 > a->v[0])
        a->falls[0] = share * falls0 + (1.0 - share) * foot0;
    for (int k = 0; k < a->places; k++) {
        room[k] = a->rises[k] + a->falls[k], unbent[k] = a->idle[k] + a->foot[k];
        slope[k] = (a->idle[k] - a->rises[k]) / a->v[k]; /* the more v is below that place the slower it rises */
    }
    if (a->rises[0] < 0.0 || a->falls[0] < 0.0) /* an axis that bears more of c later than it gains now asks for nothing */
        use(a, 1, USEFUL);
    if (a->rises[0] + a->falls[0] < 0.0) /* an axis that turns back can hardly be helped by c: the others decide */
        use(a, 0, HEAVY * tight);
    edge(a, room, unbent);
    if (turns != Py_None && turned(a, turns, flip, braking) < 0)
        return -1;
    a->lowest[a->places - 1] = 0.0;
    *room_next = least(a->rises[1], a->falls[1]);
    if (dt > a->h) /* the next period lies between the first two places */
        *room_next = least(*room_next, least(a->rises[0], a->falls[0]));
    for (int k = 0; k < a->places; k++)
        a->falls[k] = -a->falls[k];
    risen(a, slope);
    double lowest = v0 + a->falls[0] * dt, most = -INFINITY, first;
    for (int k = 0; k < a->places; k++) {
        a->base[k] = a->lowest[k] / a->scale[k] - a->sum[k];
        most = k ? greatest(a->base[k], most) : most;
    }
    if (v0 <= 0.0) /* from the lowest v of place 1 every place behind can still be met */
        lowest = least(greatest(a->scale[1] * (most + a->sum[1]), lowest), 0.0);
    double highest = greatest(a->scale[1] * (a->sum[1] + v0), v0 - a->most_c * dt);
    if (now->steady && v0 <= 0.0) /* never above what c can reach now */
        lowest = least(foreseen + BOLD * (lowest - foreseen), greatest(lowest, highest));
    int lands = landing(a, flip * (now->w - now->wanted) / (braking ? SPARE : AMPLE), v0, lowest, highest, &first);
    if (lands)
        for (int k = 1; k < a->places; k++)
            a->way[k] = back(a, k, first);
    else
        down(a, v0);
    first = least(first, highest + RESERVE * tight * dt);
    a->way[0] = v0, a->way[1] = first;
    keep(a, seen, flip);
    *c = flip * (first - v0) / dt;
    return 0;
}

static PyObject *step(PyObject *module, PyObject *arguments)
{
    PyObject *capsule, *window, *foreseen, *turns, *result = NULL;
    long long low, end, first, past;
    double inverse, c, room;
    struct state now;
    if (!PyArg_ParseTuple(arguments, "OOLLLLdOpddddO", &capsule, &window, &low, &end, &first, &past, &inverse, &foreseen, &now.steady,
                          &now.tau, &now.w, &now.u, &now.wanted, &turns))
        return NULL;
    struct ahead *a = PyCapsule_GetPointer(capsule, AHEAD);
    Py_buffer rows, seen;
    if (!a || PyObject_GetBuffer(window, &rows, PyBUF_C_CONTIGUOUS) < 0)
        return NULL;
    if (PyObject_GetBuffer(foreseen, &seen, PyBUF_WRITABLE | PyBUF_C_CONTIGUOUS) < 0) {
        PyBuffer_Release(&rows);
        return NULL;
    }
    Py_ssize_t size = rows.len / (Py_ssize_t)sizeof(double) / PARTS / a->columns;
    if (seen.len != a->places * (Py_ssize_t)sizeof(double) || end - low > size || (turns != Py_None && !PyList_Check(turns))) {
        PyErr_SetString(PyExc_ValueError, "foresight: rows, places or turns are not as they were made");
        goto done;
    }
    int braking = fabs(now.w) > fabs(now.wanted);
    double flip = now.w > now.wanted || (now.w == now.wanted && now.u > 0.0) ? 1.0 : -1.0, low_tau = INFINITY, high_tau = -INFINITY;
    double *u = seen.buf;
    u[0] = now.u;
    places(a, u, &now, flip, braking);
    for (int k = 0; k < a->places; k++) {
        low_tau = least(least(a->taus[k], a->middles[k]), low_tau);
        high_tau = greatest(greatest(a->taus[k], a->middles[k]), high_tau);
    }
    long long from = (long long)(low_tau * inverse), till = (long long)(high_tau * inverse);
    if (from < first || till >= past) {
        result = Py_BuildValue("dd(LL)", 0.0, 0.0, from, till);
        goto done;
    }
    if (end <= low) {
        PyErr_SetString(PyExc_ValueError, "foresight: no row is in view");
        goto done;
    }
    struct rows view = {rows.buf, size * a->columns, size, low, end};
    if (found(a, &view, inverse, u, &now, turns, flip, braking, &c, &room) == 0)
        result = Py_BuildValue("ddO", c, room, Py_None);
done:
    PyBuffer_Release(&seen);
    PyBuffer_Release(&rows);
    return result;
}

static inline double at(const Py_buffer *rows, int part, Py_ssize_t column, Py_ssize_t k)
{
    return *(const double *)((const char *)rows->buf + part * rows->strides[0] + column * rows->strides[1] + k * rows->strides[2]);
}

static PyObject *most(PyObject *module, PyObject *arguments)
{
    PyObject *window;
    double omega, left, u, most_u = INFINITY, spare = INFINITY, most_c = INFINITY;
    if (!PyArg_ParseTuple(arguments, "Oddd", &window, &omega, &left, &u))
        return NULL;
    Py_buffer rows;
    if (PyObject_GetBuffer(window, &rows, PyBUF_STRIDES) < 0)
        return NULL;
    if (rows.ndim != 3 || rows.itemsize != sizeof(double) || rows.shape[0] != PARTS) {
        PyBuffer_Release(&rows);
        PyErr_SetString(PyExc_ValueError, "rows are (parts, columns, rows) of float64");
        return NULL;
    }
    double square = omega * omega, cube = square * omega;
    for (Py_ssize_t n = 0; n < rows.shape[1]; n++)
        for (Py_ssize_t k = 0; k < rows.shape[2]; k++) {
            most_u = least(at(&rows, REACH, n, k) - fabs(at(&rows, BEND, n, k)) * square, most_u);
            spare = least(at(&rows, PULL, n, k) - fabs(at(&rows, TWIST, n, k)) * cube, spare);
        }
    double tilt = omega * least(most_u, sqrt(greatest(spare, 0.0) * fabs(left) + u * u));
    for (Py_ssize_t n = 0; n < rows.shape[1]; n++)
        for (Py_ssize_t k = 0; k < rows.shape[2]; k++)
            most_c = least(at(&rows, PULL, n, k) - fabs(at(&rows, TWIST, n, k)) * cube - fabs(at(&rows, LEAN, n, k)) * tilt, most_c);
    PyBuffer_Release(&rows);
    return Py_BuildValue("dd", most_u, most_c);
}

static PyMethodDef METHODS[] = {
    {"ahead", make_ahead, METH_VARARGS, NULL},
    {"step", step, METH_VARARGS, NULL},
    {"most", most, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef MODULE = {PyModuleDef_HEAD_INIT, .m_name = "foresight", .m_size = -1, .m_methods = METHODS};

PyMODINIT_FUNC PyInit_foresight(void)
{
    return PyModule_Create(&MODULE);
}
