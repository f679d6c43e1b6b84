// modbus-serial (npm) as a judge of our server: node npm_client.js PORT, NODE_PATH=build/node/node_modules.
// Expects unit 1 with 2000 of everything, input register N = 1000 + N, discrete input N set where N is a multiple of 3.
// Prints one line per check ("ok ..." or "FAIL ..."); exit 0 when all are ok.
"use strict";
const ModbusRTU = require("modbus-serial");
const assert = require("assert");
const client = new ModbusRTU();
let failed = 0;

async function check(what, action) {
    try {
        await action();
        console.log("ok " + what);
    } catch (error) {
        failed += 1;
        console.log("FAIL " + what + ": " + error.message);
    }
}

async function refused(code, action) {
    await assert.rejects(action, (error) => error.modbusCode === code);
}

async function main() {
    await client.connectTCP("127.0.0.1", { port: Number(process.argv[2]) });
    client.setTimeout(10000);
    client.setID(1);
    await check("FC 5 and FC 1", async () => {
        await client.writeCoil(4, true);
        assert.deepStrictEqual((await client.readCoils(3, 3)).data.slice(0, 3), [false, true, false]);
    });
    await check("FC 15 with 1968 coils and FC 1 with 2000", async () => {
        const out = Array.from({ length: 1968 }, (_, n) => (n * 7) % 5 > 2);
        await client.writeCoils(0, out);
        assert.deepStrictEqual((await client.readCoils(0, 2000)).data.slice(0, 1968), out);
    });
    await check("FC 2", async () => {
        assert.deepStrictEqual((await client.readDiscreteInputs(3, 4)).data.slice(0, 4), [true, false, false, true]);
    });
    await check("FC 6 and FC 3", async () => {
        await client.writeRegister(7, 0xbeef);
        assert.deepStrictEqual((await client.readHoldingRegisters(6, 3)).data, [0, 0xbeef, 0]);
    });
    await check("FC 16 with 123 registers and FC 3 with 125", async () => {
        const out = Array.from({ length: 123 }, (_, n) => (n * 523) & 0xffff);
        await client.writeRegisters(100, out);
        assert.deepStrictEqual((await client.readHoldingRegisters(100, 125)).data, out.concat([0, 0]));
    });
    await check("FC 4", async () => {
        assert.deepStrictEqual((await client.readInputRegisters(1, 3)).data, [1001, 1002, 1003]);
    });
    await check("FC 22", async () => {
        await client.writeRegister(50, 0x12);
        await client.maskWriteRegister(50, 0xf2, 0x25);
        assert.deepStrictEqual((await client.readHoldingRegisters(50, 1)).data, [0x17]);
    });
    await check("FC 17", async () => {
        const id = await client.reportServerID(0, 0);
        assert.strictEqual(id.serverId, 1);
        assert.strictEqual(id.running, true);
        assert.strictEqual(id.additionalData.toString("latin1").slice(0, 8), "axisgate");
    });
    await check("FC 43/14", async () => {
        assert.strictEqual((await client.readDeviceIdentification(1, 0)).data[0], "axisgate");
    });
    await check("02 beyond the table", () => refused(2, client.readHoldingRegisters(1999, 2)));
    await check("03 for 126 registers", () => refused(3, client.readHoldingRegisters(0, 126)));
    await check("0B for a unit that is not there", async () => {
        client.setID(9);
        await refused(11, client.readHoldingRegisters(0, 1));
    });
    client.close(() => process.exit(failed ? 1 : 0));
}

main().catch((error) => {
    console.log("FAIL " + error.message);
    process.exit(3);
});
