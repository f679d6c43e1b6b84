/* A libmodbus client as the judge of our server: all function codes, their limits and exceptions.
 *
 *   libmodbus_client PORT|DEVICE   gcc -O2 -o build/libmodbus_client libmodbus_client.c -lmodbus
 *
 * Expects unit 1 with 2000 of everything, input register N = 1000 + N, discrete input N set where N is a multiple of 3, and no other
 * unit.  Prints one line per check ("ok ..." or "FAIL ..."); exit 0 when all are ok, 1 when one is not, 3 without a connection.
 */
#include <errno.h>
#include <modbus/modbus.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static modbus_t *server;
static int failed, serial;

static void check(int holds, const char *what)
{
    printf("%s %s%s%s\n", holds ? "ok" : "FAIL", what, holds ? "" : ": ", holds ? "" : modbus_strerror(errno));
    failed += !holds;
}

/* The call must have been refused with this error. */
static void refused(int result, int error, const char *what)
{
    check(result == -1 && errno == error, what);
}

/* Sends a PDU libmodbus would not send by itself; the answer must be the exception `code` with the function code and 80h. */
static void raw(const uint8_t *pdu, int bytes, int code, const char *what)
{
    uint8_t request[MODBUS_MAX_PDU_LENGTH + 1] = {1}, answer[MODBUS_TCP_MAX_ADU_LENGTH];
    memcpy(request + 1, pdu, bytes);
    int got = modbus_send_raw_request(server, request, bytes + 1) < 0 ? -1 : modbus_receive_confirmation(server, answer);
    int at = serial ? 1 : 7; /* the unit alone, or the header before it */
    check(got == (serial ? 5 : 9) && answer[at] == (pdu[0] | 0x80) && answer[at + 1] == code, what);
}

static void bits(void)
{
    static uint8_t out[MODBUS_MAX_READ_BITS], in[MODBUS_MAX_READ_BITS];
    int good = 1;
    check(modbus_write_bit(server, 5, 1) == 1 && modbus_read_bits(server, 4, 3, in) == 3 && !in[0] && in[1] && !in[2], "FC 5 and FC 1");
    for (int n = 0; n < MODBUS_MAX_WRITE_BITS; n++)
        out[n] = n * 7 % 5 > 2;
    check(modbus_write_bits(server, 0, MODBUS_MAX_WRITE_BITS, out) == MODBUS_MAX_WRITE_BITS, "FC 15 with 1968 coils");
    check(modbus_read_bits(server, 0, MODBUS_MAX_READ_BITS, in) == MODBUS_MAX_READ_BITS, "FC 1 with 2000 coils");
    check(!memcmp(out, in, MODBUS_MAX_READ_BITS), "coils come back as written, those behind are 0");
    check(modbus_read_input_bits(server, 0, MODBUS_MAX_READ_BITS, in) == MODBUS_MAX_READ_BITS, "FC 2 with 2000 inputs");
    for (int n = 0; n < MODBUS_MAX_READ_BITS; n++)
        good &= in[n] == (n % 3 == 0);
    check(good, "discrete inputs in their places");
}

static void registers(void)
{
    uint16_t out[MODBUS_MAX_WRITE_REGISTERS], in[MODBUS_MAX_READ_REGISTERS];
    int good = 1;
    check(modbus_write_register(server, 7, 0xBEEF) == 1 && modbus_read_registers(server, 6, 3, in) == 3 && in[1] == 0xBEEF, "FC 6 and FC 3");
    for (int n = 0; n < MODBUS_MAX_WRITE_REGISTERS; n++)
        out[n] = n * 521;
    check(modbus_write_registers(server, 100, MODBUS_MAX_WRITE_REGISTERS, out) == MODBUS_MAX_WRITE_REGISTERS, "FC 16 with 123 registers");
    check(modbus_read_registers(server, 100, MODBUS_MAX_READ_REGISTERS, in) == MODBUS_MAX_READ_REGISTERS, "FC 3 with 125 registers");
    check(!memcmp(out, in, sizeof out) && !in[123] && !in[124], "registers come back as written, those behind are 0");
    check(modbus_read_input_registers(server, 50, MODBUS_MAX_READ_REGISTERS, in) == MODBUS_MAX_READ_REGISTERS, "FC 4 with 125 registers");
    for (int n = 0; n < MODBUS_MAX_READ_REGISTERS; n++)
        good &= in[n] == 1050 + n;
    check(good, "input registers in their places");
}

static void exceptions(void)
{
    uint8_t bit[16] = {0};
    uint16_t word[16] = {0};
    refused(modbus_read_bits(server, 1999, 2, bit), EMBXILADD, "FC 1 beyond the table: 02");
    refused(modbus_read_input_bits(server, 1999, 2, bit), EMBXILADD, "FC 2 beyond the table: 02");
    refused(modbus_read_registers(server, 1999, 2, word), EMBXILADD, "FC 3 beyond the table: 02");
    refused(modbus_read_input_registers(server, 65535, 2, word), EMBXILADD, "FC 4 beyond 65535: 02");
    refused(modbus_write_bit(server, 2000, 1), EMBXILADD, "FC 5 beyond the table: 02");
    refused(modbus_write_register(server, 2000, 1), EMBXILADD, "FC 6 beyond the table: 02");
    refused(modbus_write_bits(server, 1999, 2, bit), EMBXILADD, "FC 15 beyond the table: 02");
    refused(modbus_write_registers(server, 1999, 2, word), EMBXILADD, "FC 16 beyond the table: 02");
    refused(modbus_mask_write_register(server, 2000, 0, 0), EMBXILADD, "FC 22 beyond the table: 02");
    refused(modbus_write_and_read_registers(server, 0, 1, word, 1999, 2, word), EMBXILADD, "FC 23, what is read beyond the table: 02");
    refused(modbus_write_and_read_registers(server, 1999, 2, word, 0, 1, word), EMBXILADD, "FC 23, what is written beyond it: 02");
    raw((const uint8_t[]){1, 0, 0, 0, 0}, 5, 3, "FC 1 with 0 coils: 03");
    raw((const uint8_t[]){3, 0, 0, 0, 126}, 5, 3, "FC 3 with 126 registers: 03");
    raw((const uint8_t[]){5, 0, 0, 0, 1}, 5, 3, "FC 5 with 0001h: 03");
    raw((const uint8_t[]){15, 0, 0, 0, 9, 1, 0xFF}, 7, 3, "FC 15 with a wrong byte count: 03");
    raw((const uint8_t[]){16, 0, 0, 0, 1, 1, 0xFF}, 7, 3, "FC 16 with a wrong byte count: 03");
    raw((const uint8_t[]){3, 0, 0}, 3, 3, "FC 3 too short: 03");
    raw((const uint8_t[]){0x41, 0, 0, 0, 1}, 5, 1, "FC 41h: 01");
}

static void others(void)
{
    uint16_t out[2] = {0x0012, 0x0034}, in[4] = {0};
    uint8_t id[256];
    modbus_write_register(server, 1900, 0x0012);
    check(modbus_mask_write_register(server, 1900, 0x00F2, 0x0025) == 1, "FC 22");
    check(modbus_read_registers(server, 1900, 1, in) == 1 && in[0] == 0x0017, "FC 22 kept and set as V1.1b3, 6.16, prints it");
    check(modbus_write_and_read_registers(server, 1901, 2, out, 1900, 4, in) == 4 && in[0] == 0x17 && in[1] == 0x12 && in[2] == 0x34 && !in[3],
          "FC 23 writes before it reads");
    check(modbus_report_slave_id(server, sizeof id, id) > 2 && id[0] == 1 && id[1] == 0xFF && !memcmp(id + 2, "axisgate", 8), "FC 17");
}

static void units(void)
{
    uint16_t word[2];
    if (serial) {
        modbus_set_response_timeout(server, 0, 300000);
        modbus_set_slave(server, 9);
        refused(modbus_read_registers(server, 0, 1, word), ETIMEDOUT, "unit 9 is not there: silence");
        modbus_set_response_timeout(server, 10, 0);
        modbus_set_slave(server, 1);
        check(modbus_read_input_registers(server, 3, 1, word) == 1 && word[0] == 1003, "unit 1 after it");
        return;
    }
    modbus_set_slave(server, 9);
    refused(modbus_read_registers(server, 0, 1, word), EMBXGTAR, "unit 9 is not there: 0B");
    modbus_set_slave(server, MODBUS_TCP_SLAVE);
    check(modbus_read_input_registers(server, 1, 1, word) == 1 && word[0] == 1001, "unit 255 is the server itself");
    modbus_set_slave(server, 0);
    check(modbus_read_input_registers(server, 2, 1, word) == 1 && word[0] == 1002, "unit 0 is the server itself and is answered");
    modbus_set_slave(server, 1);
    check(modbus_read_input_registers(server, 3, 1, word) == 1 && word[0] == 1003, "unit 1 after all of it");
}

int main(int argc, char **argv)
{
    serial = argc > 1 && argv[1][0] == '/';
    server = serial ? modbus_new_rtu(argv[1], 115200, 'N', 8, 1) : modbus_new_tcp("127.0.0.1", argc > 1 ? atoi(argv[1]) : 1502);
    if (!server || modbus_connect(server) < 0) {
        fprintf(stderr, "libmodbus_client: %s\n", modbus_strerror(errno));
        return 3;
    }
    modbus_set_slave(server, 1);
    modbus_set_response_timeout(server, 5, 0);
    bits();
    registers();
    exceptions();
    others();
    units();
    modbus_close(server);
    modbus_free(server);
    return failed ? 1 : 0;
}
