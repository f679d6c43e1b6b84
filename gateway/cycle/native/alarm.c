/* Waiting for an instant of the cycle's grid, in C (AX-320); twin: gateway.runtime.realtime.Alarm.until.
 *
 *   until(due_ns, ahead_ns) -> (time at which it woke, time on return): asleep to due - ahead, awake from there to due
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <stdint.h>
#include <time.h>

#define SECOND_NS 1000000000LL

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * SECOND_NS + t.tv_nsec;
}

static PyObject *until(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    int64_t due = count == 2 ? PyLong_AsLongLong(args[0]) : -1, ahead = count == 2 ? PyLong_AsLongLong(args[1]) : 0;
    if (PyErr_Occurred() || due < ahead || ahead < 0)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_ValueError, "an instant and how long to be awake before it expected");
    int64_t wake = due - ahead, woke, now;
    struct timespec t = {wake / SECOND_NS, wake % SECOND_NS};
    while ((woke = now_ns()) < wake) { /* again after a signal */
        Py_BEGIN_ALLOW_THREADS
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals() < 0)
            return NULL;
    }
    for (now = woke; now < due; now = now_ns())
        ;
    return Py_BuildValue("(LL)", (long long)woke, (long long)now);
}

static PyMethodDef methods[] = {
    {"until", (PyCFunction)(void (*)(void))until, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "alarm", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_alarm(void)
{
    return PyModule_Create(&module);
}
