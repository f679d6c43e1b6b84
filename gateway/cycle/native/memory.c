/* What the cycle puts into shared memory, in C (AX-320).
 *
 *   packing(CellState, AxisState, names, codes, axis names, axis codes, axes, size) -> packing;   pack(packing, state) -> octets
 *   look(links, planner, pieces, orders, inputs) -> (pid and last beat of the services, pid of the planner, published of the last three)
 *   write(memory, stride, payload, stamp_ns), beat(memory, stamp_ns), put(memory, stride, record)
 *
 * Twins: gateway.pure.image.records.cell.cell_state_packer; RegionWriter.write and beat, RingWriter.put of gateway.runtime.regions (bytes: AX-090, order of the
 * stores: AX-091).
 */
#include "slots.h"

#include <stdatomic.h>
#include <stdint.h>
#include <string.h>

#define HEADER_BYTES 256
#define SLOT_HEADER_BYTES 16
#define REGION_SLOTS 4
#define MOST_FIELDS 64
enum { SIZE = 3, COUNT = 4, WRITER = 5, PUBLISHED = 6, LIFE = 7, LIFE_STAMP = 8 }; /* words of the header */

struct fields {
    int count;
    Py_ssize_t place[MOST_FIELDS];
    char code[MOST_FIELDS];
};

struct packing {
    PyTypeObject *state, *axis;
    Py_ssize_t axes_place;
    int axes;
    Py_ssize_t size;
    struct fields head, each;
};

static const char PACKING[] = "axisgate.packing";

/* 0, or -1 with an exception.  Integers that do not fit raise OverflowError. */
static int pack_one(char code, PyObject *value, char **to)
{
    double real;
    unsigned long long whole;
    long long with_sign;
    if (!value) {
        PyErr_SetString(PyExc_AttributeError, "a slot is empty");
        return -1;
    }
    switch (code) {
    case 'd':
        real = PyFloat_AsDouble(value);
        memcpy(*to, &real, sizeof real);
        *to += sizeof real;
        break;
    case 'q':
        with_sign = PyLong_AsLongLong(value);
        memcpy(*to, &with_sign, sizeof with_sign);
        *to += sizeof with_sign;
        break;
    default:
        whole = PyLong_AsUnsignedLongLong(value);
        int size = code == 'B' ? 1 : code == 'H' ? 2 : code == 'I' ? 4 : 8;
        if (size < 8 && whole >> 8 * size && !PyErr_Occurred())
            PyErr_Format(PyExc_OverflowError, "%llu does not fit %d octets", whole, size);
        uint8_t one = (uint8_t)whole;
        uint16_t two = (uint16_t)whole;
        uint32_t four = (uint32_t)whole;
        memcpy(*to, size == 1 ? (void *)&one : size == 2 ? (void *)&two : size == 4 ? (void *)&four : (void *)&whole, (size_t)size);
        *to += size;
    }
    return PyErr_Occurred() ? -1 : 0;
}

static int pack_fields(const struct fields *fields, PyObject *object, char **to)
{
    for (int n = 0; n < fields->count; n++)
        if (pack_one(fields->code[n], SLOT(object, fields->place[n]), to) < 0)
            return -1;
    return 0;
}

static PyObject *pack(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    struct packing *packing = count == 2 ? PyCapsule_GetPointer(args[0], PACKING) : NULL;
    if (!packing || Py_TYPE(args[1]) != packing->state)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "packing and state expected");
    PyObject *axes = SLOT(args[1], packing->axes_place), *made = PyBytes_FromStringAndSize(NULL, packing->size);
    if (!made)
        return NULL;
    char *to = PyBytes_AS_STRING(made);
    memset(to, 0, (size_t)packing->size);
    int good = axes && PyList_CheckExact(axes) && PyList_GET_SIZE(axes) >= packing->axes;
    if (!good)
        PyErr_SetString(PyExc_TypeError, "a list of the states of all axes expected");
    good = good && pack_fields(&packing->head, args[1], &to) == 0;
    for (int n = 0; good && n < packing->axes; n++) {
        PyObject *axis = PyList_GET_ITEM(axes, n);
        good = Py_TYPE(axis) == packing->axis;
        if (!good)
            PyErr_Format(PyExc_TypeError, "%R is no state of an axis", axis);
        good = good && pack_fields(&packing->each, axis, &to) == 0;
    }
    if (!good)
        Py_CLEAR(made);
    return made;
}

static int find_fields(struct fields *fields, PyObject *type, PyObject *names, const char *codes)
{
    fields->count = (int)strlen(codes);
    if (fields->count > MOST_FIELDS || fields->count != PyTuple_GET_SIZE(names) || strspn(codes, "BHIQqd") != strlen(codes)) {
        PyErr_Format(PyExc_TypeError, "%R as %s", names, codes);
        return -1;
    }
    memcpy(fields->code, codes, (size_t)fields->count);
    for (int n = 0; n < fields->count; n++) {
        const char *name[2] = {PyUnicode_AsUTF8(PyTuple_GET_ITEM(names, n)), NULL};
        if (!name[0] || find_places(type, name, &fields->place[n]) < 0)
            return -1;
    }
    return 0;
}

static void forget(PyObject *capsule)
{
    struct packing *packing = PyCapsule_GetPointer(capsule, PACKING);
    Py_XDECREF(packing->state);
    Py_XDECREF(packing->axis);
    PyMem_Free(packing);
}

static PyObject *make_packing(PyObject *self, PyObject *args)
{
    static const char *const axes_name[] = {"axes", NULL};
    PyObject *state, *axis, *names, *axis_names;
    const char *codes, *axis_codes;
    struct packing *packing = PyMem_Calloc(1, sizeof *packing);
    PyObject *capsule = packing ? PyCapsule_New(packing, PACKING, forget) : PyErr_NoMemory();
    if (!capsule)
        return NULL;
    if (!PyArg_ParseTuple(args, "O!O!O!sO!sin", &PyType_Type, &state, &PyType_Type, &axis, &PyTuple_Type, &names, &codes, &PyTuple_Type,
                          &axis_names, &axis_codes, &packing->axes, &packing->size)
        || find_places(state, axes_name, &packing->axes_place) < 0 || find_fields(&packing->head, state, names, codes) < 0
        || find_fields(&packing->each, axis, axis_names, axis_codes) < 0)
        Py_CLEAR(capsule);
    if (capsule) {
        packing->state = (PyTypeObject *)Py_NewRef(state);
        packing->axis = (PyTypeObject *)Py_NewRef(axis);
    }
    return capsule;
}

/* Words of a region or ring whose memory is at least as long as its header says; NULL with an exception. */
static uint64_t *words_of(PyObject *memory, Py_buffer *view, Py_ssize_t stride)
{
    if (PyObject_GetBuffer(memory, view, PyBUF_WRITABLE) < 0)
        return NULL;
    uint64_t *words = view->buf;
    if (view->len >= HEADER_BYTES && (uintptr_t)words % 8 == 0
        && (stride == 0 || (uint64_t)view->len >= HEADER_BYTES + words[COUNT] * (uint64_t)stride))
        return words;
    PyBuffer_Release(view);
    PyErr_SetString(PyExc_ValueError, "no region or ring");
    return NULL;
}

/* Everything stored before is seen by whoever sees this. */
static void publish(uint64_t *word, uint64_t value)
{
    atomic_store_explicit((_Atomic uint64_t *)word, value, memory_order_release);
}

/* The payload into slot `number`; 0, or -1 with an exception. */
static int fill(uint64_t *words, uint64_t at, PyObject *octets)
{
    Py_buffer view;
    if (PyObject_GetBuffer(octets, &view, PyBUF_SIMPLE) < 0)
        return -1;
    int fits = (uint64_t)view.len == words[SIZE];
    if (fits)
        memcpy((char *)words + at, view.buf, (size_t)view.len);
    else
        PyErr_Format(PyExc_ValueError, "%llu bytes expected, %zd given", (unsigned long long)words[SIZE], view.len);
    PyBuffer_Release(&view);
    return fits ? 0 : -1;
}

static PyObject *write_region(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    Py_buffer view;
    Py_ssize_t stride = count == 4 ? PyLong_AsSsize_t(args[1]) : -1;
    long long stamp = stride > 0 ? PyLong_AsLongLong(args[3]) : 0;
    uint64_t *words = stride > 0 && !PyErr_Occurred() ? words_of(args[0], &view, stride) : NULL;
    if (!words)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "memory, stride, payload and stamp expected");
    uint64_t index = words[PUBLISHED] + 1, at = HEADER_BYTES + index % REGION_SLOTS * (uint64_t)stride;
    words[at / 8] = (uint64_t)stamp;
    int done = fill(words, at + SLOT_HEADER_BYTES, args[2]);
    if (done == 0)
        publish(&words[PUBLISHED], index);
    PyBuffer_Release(&view);
    return done == 0 ? PyLong_FromUnsignedLongLong(index) : NULL;
}

static PyObject *put_record(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    Py_buffer view;
    Py_ssize_t stride = count == 3 ? PyLong_AsSsize_t(args[1]) : -1;
    uint64_t *words = stride > 0 ? words_of(args[0], &view, stride) : NULL;
    if (!words)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "memory, stride and record expected");
    uint64_t sequence = words[PUBLISHED] + 1;
    int done = fill(words, HEADER_BYTES + sequence % words[COUNT] * (uint64_t)stride, args[2]);
    if (done == 0)
        publish(&words[PUBLISHED], sequence);
    PyBuffer_Release(&view);
    return done == 0 ? PyLong_FromUnsignedLongLong(sequence) : NULL;
}

static PyObject *beat(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    Py_buffer view;
    long long stamp = count == 2 ? PyLong_AsLongLong(args[1]) : 0;
    uint64_t *words = count == 2 && !PyErr_Occurred() ? words_of(args[0], &view, 0) : NULL;
    if (!words)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_TypeError, "memory and stamp expected");
    uint64_t life = words[LIFE] + 1;
    words[LIFE_STAMP + (life & 1)] = (uint64_t)stamp;
    publish(&words[LIFE], life);
    PyBuffer_Release(&view);
    Py_RETURN_NONE;
}

/* Words of what is only read; NULL without an exception: there is none. */
static const uint64_t *words_to_read(PyObject *memory)
{
    const Py_buffer *view = PyMemoryView_Check(memory) ? PyMemoryView_GET_BUFFER(memory) : NULL;
    return view && view->buf && view->len >= HEADER_BYTES && (uintptr_t)view->buf % 8 == 0 ? view->buf : NULL;
}

static uint64_t read_word(const uint64_t *words, int at)
{
    return words ? atomic_load_explicit((const _Atomic uint64_t *)&words[at], memory_order_acquire) : 0;
}

static PyObject *look(PyObject *self, PyObject *const *args, Py_ssize_t count)
{
    if (count != 5)
        return PyErr_Format(PyExc_TypeError, "five memories expected");
    const uint64_t *links = words_to_read(args[0]);
    uint64_t life = read_word(links, LIFE), stamp = read_word(links, LIFE_STAMP + (life & 1));
    if (read_word(links, LIFE) != life) { /* it beat meanwhile: once more */
        life = read_word(links, LIFE);
        stamp = read_word(links, LIFE_STAMP + (life & 1));
    }
    return Py_BuildValue("(kLkKKK)", (unsigned long)(read_word(links, WRITER) & 0xFFFFFFFF), (long long)stamp,
                         (unsigned long)(read_word(words_to_read(args[1]), WRITER) & 0xFFFFFFFF),
                         (unsigned long long)read_word(words_to_read(args[2]), PUBLISHED),
                         (unsigned long long)read_word(words_to_read(args[3]), PUBLISHED),
                         (unsigned long long)read_word(words_to_read(args[4]), PUBLISHED));
}

static PyMethodDef methods[] = {
    {"look", (PyCFunction)(void (*)(void))look, METH_FASTCALL, NULL},
    {"packing", make_packing, METH_VARARGS, NULL},
    {"pack", (PyCFunction)(void (*)(void))pack, METH_FASTCALL, NULL},
    {"write", (PyCFunction)(void (*)(void))write_region, METH_FASTCALL, NULL},
    {"put", (PyCFunction)(void (*)(void))put_record, METH_FASTCALL, NULL},
    {"beat", (PyCFunction)(void (*)(void))beat, METH_FASTCALL, NULL},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "memory", NULL, -1, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit_memory(void)
{
    return PyModule_Create(&module);
}
