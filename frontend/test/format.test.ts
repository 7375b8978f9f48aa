import assert from "node:assert/strict";
import { test } from "node:test";
import { csv } from "../src/format/csv";
import { ticks, typed, zoomed } from "../src/format/range";
import { clock, fixed, mark, number, quantity, reading, unitFor } from "../src/format/units";
import { limit } from "../src/format/range";

test("stress gets the prefix of its size", () => {
  assert.equal(unitFor("Pa", 291.5e6).label, "MPa");
  assert.equal(unitFor("Pa", 0.2e6).label, "MPa");
  assert.equal(unitFor("Pa", 40e3).label, "kPa");
  assert.equal(unitFor("Pa", 3).label, "Pa");
  assert.equal(unitFor("Pa", -291.5e6).label, "MPa");
  assert.equal(quantity(291.5e6, "Pa"), "291.5 MPa");
});

test("lengths are millimetres below one metre", () => {
  assert.equal(quantity(0.006127, "m"), "6.127 mm");
  assert.equal(quantity(2.5, "m"), "2.500 m");
  assert.equal(quantity(-0.25, "m", 3), "−250 mm");
  assert.equal(quantity(3e-6, "m", 2), "3.0 µm");
});

test("what is no more than rounding is zero", () => {
  assert.equal(quantity(reading(9.157e-17, 1e-14), "m"), "0 mm");
  assert.equal(quantity(reading(-4.635e-9, 1e-6), "Pa"), "0 MPa");
  assert.equal(quantity(reading(-2e-14, 1e-14), "m", 2), "−2.0·10⁻⁸ µm");
});

test("quantities without a prefix keep their unit", () => {
  assert.equal(quantity(0.31, "1", 2), "0.31");
  assert.equal(quantity(1.5, "rad", 2), "1.5 rad");
  assert.equal(quantity(12500, "N", 3), "12.5 kN");
  assert.equal(quantity(2000, "N", 3), "2.00 kN");
});

test("values that are unknown are a dash, not zero", () => {
  assert.equal(quantity(null, "Pa"), "–");
  assert.equal(number(NaN), "–");
  assert.equal(number(0), "0");
});

test("very small and very large numbers use powers of ten", () => {
  assert.equal(number(1.234e-7, 3), "1.23·10⁻⁷");
  assert.equal(number(5e8, 2), "5.0·10⁸");
});

test("marks have no zeros at their ends", () => {
  assert.equal(mark(200), "200");
  assert.equal(mark(0.25), "0.25");
  assert.equal(mark(-1.5), "−1.5");
  assert.equal(mark(2e6), "2·10⁶");
  assert.equal(mark(100), "100");
});

test("clock has the decimals of the frames", () => {
  assert.equal(clock(1.23456, 0.01), "1.23");
  assert.equal(clock(1.23456, 0.001), "1.235");
  assert.equal(clock(2, 1), "2");
});

test("ticks are round numbers within the range", () => {
  assert.deepEqual(ticks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks(-3, 3, 6), [-3, -2, -1, 0, 1, 2, 3]);
  assert.deepEqual(ticks(13, 287, 5), [100, 200]);
  assert.deepEqual(ticks(4, 4, 5), [4]);
});

test("a typed range is two numbers in order, or a sentence", () => {
  assert.deepEqual(typed("0", "2,5"), [0, 2.5]);
  assert.match(typed("2", "1") as string, /below/);
  assert.match(typed("", "1") as string, /numbers/);
});

test("a zoomed window keeps the instant at its place and stays within the run", () => {
  assert.deepEqual(zoomed([0, 8], [0, 8], 2, 0.5), [1, 5]);
  assert.deepEqual(zoomed([1, 5], [0, 8], 1, 2), [0, 8]);
  assert.deepEqual(zoomed([4, 8], [0, 100], 8, 2), [0, 8]);
});

test("CSV joins curves by time, with cells quoted where needed", () => {
  const text = csv([
    { label: 'stress, "top"', unit: "Pa", time: [0, 1], values: [1.5, NaN] },
    { label: "u", unit: "m", time: [0.5, 1, 1], values: [1, 2, 3] },
  ]);
  assert.equal(text, 'time [s],"stress, ""top"" [Pa]",u [m]\r\n0,1.5,\r\n0.5,,1\r\n1,,3\r\n');
});

test("what rounds to zero has no sign", () => {
  assert.equal(fixed(-0.00001, 4), "0.0000");
  assert.equal(fixed(-0.25, 2), "−0.25");
  assert.equal(clock(-1e-9, 0.001), "0.000");
});

test("the ends of a range are told apart", () => {
  assert.equal(limit(14.63, 14.63), "14.6");
  assert.equal(limit(101.23, 0.7), "101.23");
  assert.equal(limit(-1e-14, 5), "0");
  assert.equal(limit(250, 250), "250");
});
