/* Steps of one emulated servo axis, in C (AX-1020).
 *
 *   run(state, constants, step, n, substeps) -> (steps not run, trip)
 *
 * Twin: drivers.emulator.servo.model.run, whose names these are; the same sums in the same order, bit for bit.
 */
#include <Python.h>

#include <math.h>

#define STATE 27
#define OWN 12 /* the first row of the state, which runs by itself */
#define CONSTANTS 23
#define MODULUS 2147483647.0

static int taken(PyObject *items, Py_ssize_t count, double *to, int list)
{
    Py_ssize_t i;
    if (list ? !PyList_CheckExact(items) || PyList_GET_SIZE(items) != count : !PyTuple_CheckExact(items) || PyTuple_GET_SIZE(items) != count) {
        PyErr_Format(PyExc_TypeError, "run: %zd numbers are expected", count);
        return 0;
    }
    for (i = 0; i < count; i++) {
        to[i] = PyFloat_AsDouble(list ? PyList_GET_ITEM(items, i) : PyTuple_GET_ITEM(items, i));
        if (to[i] == -1.0 && PyErr_Occurred())
            return 0;
    }
    return 1;
}

static PyObject *run(PyObject *self, PyObject *const *arguments, Py_ssize_t count)
{
    double s[STATE], c[CONSTANTS], d, x, v, e;
    long step, n, substeps, trip = 0, i;
    int phase, single;
    if (count != 5) {
        PyErr_SetString(PyExc_TypeError, "run: state, constants, step, n, substeps are expected");
        return NULL;
    }
    if (!taken(arguments[0], STATE, s, 1) || !taken(arguments[1], CONSTANTS, c, 0))
        return NULL;
    step = PyLong_AsLong(arguments[2]);
    n = PyLong_AsLong(arguments[3]);
    substeps = PyLong_AsLong(arguments[4]);
    if (PyErr_Occurred())
        return NULL;
    double th = s[0], w = s[1], tm = s[2], tr = s[3], it = s[4], wr = s[5], left = s[6], i2t = s[7], temp = s[8], rng = s[9], load = s[10],
           rest = s[11];
    const double goal = s[12], rate = s[13], ff = s[14], mode = s[15], fs = s[16], fc = s[17], wlo = s[18], whi = s[19], smin = s[20],
                 smax = s[21], ext = s[22], sg = s[23], ks = s[24], ko = s[25], armed = s[26];
    const double ca = c[0], cm = c[1], cv = c[2], hj = c[3], h2 = c[4], kp = c[5], ki = c[6], tmax = c[7], kv = c[8], window = c[9],
                 ramp = c[10], wmax = c[11];
    phase = (int)(step & 15);
    while (n > 0) {
        if (rest != 0.0 && n >= 16 && !phase) {
            n -= 16; /* off and stuck: 16 steps would change nothing, the slow tick below still counts */
        } else {
            single = (phase & 1) || n == 1;
            for (i = single ? substeps : 2 * substeps; i > 0; i--) {
                d = (tr - tm) * ca;
                x = tm + d * cm - load; /* mean torque over the step */
                tm += d;
                if (w > 0.0) {
                    v = w * cv + (x - fc) * hj;
                    if (v < 0.0)
                        v = 0.0; /* friction stops, it never turns the axis round */
                } else if (w < 0.0) {
                    v = w * cv + (x + fc) * hj;
                    if (v > 0.0)
                        v = 0.0;
                } else if (x > fs) {
                    v = (x - fc) * hj;
                } else if (x < -fs) {
                    v = (x + fc) * hj;
                } else {
                    continue; /* true stiction */
                }
                th += (w + v) * h2;
                w = v;
            }
            if (single) {
                phase = (phase + 1) & 15;
                n -= 1;
                if (phase & 1)
                    break;
            } else {
                phase = (phase + 2) & 15;
                n -= 2;
            }
        }
        if (!(phase & 3)) {
            if (!phase) {
                x = tm * c[12];
                x *= x;
                i2t += (x - i2t) * c[13];
                temp += (c[15] + c[16] * x - temp) * c[14];
                rng = fmod(rng * 16807.0, MODULUS);
                rng = rng == 0.0 ? 0.0 : rng < 0.0 ? rng + MODULUS : rng; /* as % does it */
                load = c[18] + ext + (rng * (2.0 / MODULUS) - 1.0) * c[22];
                if (c[19] != 0.0)
                    load += c[19] * sin(th * c[20] + c[21]);
                if (mode != 0.0 || w != 0.0) {
                    rest = 0.0;
                } else {
                    if (-1e-6 < tm && tm < 1e-6)
                        tm = 0.0;
                    rest = tm == 0.0 && -fs <= load && load <= fs ? 1.0 : 0.0;
                }
                if (armed != 0.0) {
                    if (i2t > 1.0)
                        trip = 4;
                    else if (temp > c[17])
                        trip = 5;
                }
            }
            if (mode == 1.0) {
                left -= 1.0;
                x = th * ks + ko;
                e = (left > 0.0 ? goal - rate * left : goal) - (isfinite(x) ? floor(x) : NAN);
                if ((e > window || e < -window) && armed != 0.0)
                    trip = 1;
                wr = kv * e + ff;
            } else if (mode != 0.0) {
                wr = wr > ramp ? wr - ramp : wr < -ramp ? wr + ramp : 0.0;
            }
            if (wr > smax)
                wr = smax;
            else if (wr < smin)
                wr = smin;
            if (!(-wmax < w * sg && w * sg < wmax) && armed != 0.0)
                trip = 2;
            if ((th > whi || th < wlo) && !trip)
                trip = 3;
        }
        if (mode != 0.0) {
            e = wr - w * sg;
            x = kp * e + it;
            if (x > tmax) {
                tr = tmax;
                if (e < 0.0)
                    it += ki * e; /* anti-windup: at the limit only back */
            } else if (x < -tmax) {
                tr = -tmax;
                if (e > 0.0)
                    it += ki * e;
            } else {
                tr = x;
                it += ki * e;
            }
        }
        if (trip)
            break;
    }
    const double own[OWN] = {th, w, tm, tr, it, wr, left, i2t, temp, rng, load, rest};
    for (i = 0; i < OWN; i++) {
        PyObject *number = PyFloat_FromDouble(own[i]);
        if (!number)
            return NULL;
        if (PyList_SetItem(arguments[0], i, number) < 0)
            return NULL;
    }
    return Py_BuildValue("ll", n, trip);
}

static PyMethodDef methods[] = {
    {"run", (PyCFunction)(void (*)(void))run, METH_FASTCALL, "run(state, constants, step, n, substeps) -> (steps not run, trip)"},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "servo", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_servo(void)
{
    return PyModule_Create(&module);
}
