/* Attributes of Python objects whose classes have __slots__, read and written at their places in the object: no name is looked up.
 *
 * The places are asked of the classes themselves (their member descriptors) when a module is bound, and whoever uses them has looked at
 * the object's exact type before.  A class that is built otherwise is refused at binding, and the Python twin runs (AX-320).
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <structmember.h>

#define PLACE(name) Py_ssize_t name;
#define TEXT(name) #name,
#define SLOT(object, place) (*(PyObject **)((char *)(object) + (place)))

/* The places of these names in the order given; 0, or -1 with TypeError. */
static inline int find_places(PyObject *type, const char *const *names, Py_ssize_t *places)
{
    for (; *names; names++, places++) {
        PyObject *found = PyObject_GetAttrString(type, *names);
        if (!found)
            return -1;
        if (Py_TYPE(found) != &PyMemberDescr_Type) {
            PyErr_Format(PyExc_TypeError, "%s.%s is no slot", ((PyTypeObject *)type)->tp_name, *names);
            Py_DECREF(found);
            return -1;
        }
        *places = ((PyMemberDescrObject *)found)->d_member->offset;
        Py_DECREF(found);
    }
    return 0;
}

/* Takes over the reference to `value`. */
static inline void put(PyObject *object, Py_ssize_t place, PyObject *value)
{
    PyObject *before = SLOT(object, place);
    SLOT(object, place) = value;
    Py_XDECREF(before);
}

static inline void put_known(PyObject *object, Py_ssize_t place, PyObject *value)
{
    put(object, place, Py_NewRef(value));
}

/* 0 or 1; -1 with an exception. */
static inline int truth(PyObject *value)
{
    if (value == Py_True)
        return 1;
    if (value == Py_False || value == Py_None)
        return 0;
    if (value)
        return PyObject_IsTrue(value);
    PyErr_SetString(PyExc_AttributeError, "a slot is empty");
    return -1;
}

/* -1.0 with an exception. */
static inline double real(PyObject *value)
{
    if (value)
        return PyFloat_AsDouble(value);
    PyErr_SetString(PyExc_AttributeError, "a slot is empty");
    return -1.0;
}

/* A tuple of a subclass without a dictionary (typing.NamedTuple), its items still to be filled in. */
static inline PyObject *new_record(PyTypeObject *type, Py_ssize_t count)
{
    return type->tp_alloc(type, count);
}

/* 0 when `type` is a NamedTuple with these fields, in this order; -1 with TypeError. */
static inline int check_fields(PyObject *type, const char *const *names)
{
    PyObject *fields = PyObject_GetAttrString(type, "_fields");
    Py_ssize_t n = 0;
    int good = fields && PyType_Check(type) && PyType_IsSubtype((PyTypeObject *)type, &PyTuple_Type) && PyTuple_Check(fields);
    for (; good && names[n]; n++)
        good = n < PyTuple_GET_SIZE(fields) && PyUnicode_CompareWithASCIIString(PyTuple_GET_ITEM(fields, n), names[n]) == 0;
    good = good && n == PyTuple_GET_SIZE(fields);
    Py_XDECREF(fields);
    if (!good && !PyErr_Occurred())
        PyErr_Format(PyExc_TypeError, "%R has other fields", type);
    return good ? 0 : -1;
}
