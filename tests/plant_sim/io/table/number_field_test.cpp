// SPDX-License-Identifier: Apache-2.0
#include "io/table/number_field.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(NumberField) {
  static void reads(double value, const char* text, char decimal = '.') {
    const NumberField field = number_field(text, decimal);
    CHECK_TEXT(field.kind == FieldKind::kNumber, text);
    DOUBLES_EQUAL_TEXT(value, field.value, 0.0, text);
  }
  static void is(FieldKind kind, const char* text, char decimal = '.') {
    CHECK_TEXT(number_field(text, decimal).kind == kind, text);
  }
};

TEST(NumberField, SignsFractionsAndExponentsOfEveryForm) {
  reads(1.0, "+1.0");
  reads(1000.0, "1.0E+03");
  reads(0.5, ".5");
  reads(5.0, "5.");
  reads(-0.5, "-.5");
  reads(-3.25, "\xE2\x88\x92" "3.25");
  reads(1.5e-3, "1,5e-3", ',');
  reads(-0.05, "-0,05", ',');
  reads(0.0, "1e-400");
}

TEST(NumberField, MarksBetweenThousandsNeverChangeAValueByAThousand) {
  reads(1234.5, "1,234.5");
  reads(1234567.0, "1,234,567");
  reads(1234.5, "1.234,5", ',');
  reads(1234.5, "1'234.5");
  reads(1234.5, "1\xC2\xA0" "234,5", ',');
  for (const char* text : {"12,34.5", "1,23", "0,123.5", "1,2345", "1.2.3", "1'23.5"}) is(FieldKind::kWord, text);
}

TEST(NumberField, WhatIsNoNumberIsTold) {
  for (const char* text : {"1e5x", "0x1F", "+", "-", "1 2", "--1", "+-1", "1e", "rest", "3.7 V", "."}) {
    const FieldKind kind = number_field(text, '.').kind;
    CHECK_TEXT(kind == FieldKind::kWord || kind == FieldKind::kMissing, text);
  }
  is(FieldKind::kEmpty, "");
  for (const char* text : {"NaN", "NULL", "N/A", "--", "#DIV/0!", "-1.#IND"}) is(FieldKind::kMissing, text);
  for (const char* text : {"inf", "-Inf", "1e400", "-1e999", "1.#INF"}) is(FieldKind::kNotFinite, text);
}

TEST(NumberField, DecimalSignIsProvedOrLeftOpen) {
  const auto evidence = [](const char* text) { return decimal_evidence(text); };
  CHECK(evidence("3,75") == DecimalEvidence::kComma && evidence("0,123") == DecimalEvidence::kComma);
  CHECK(evidence("1.234,5") == DecimalEvidence::kComma && evidence("1.234.567") == DecimalEvidence::kComma);
  CHECK(evidence("3.75") == DecimalEvidence::kPoint && evidence("1,234.5") == DecimalEvidence::kPoint);
  CHECK(evidence("1,234") == DecimalEvidence::kCommaOrGroups && evidence("1.234") == DecimalEvidence::kPointOrGroups);
  CHECK(evidence("12") == DecimalEvidence::kNone && evidence("a,b") == DecimalEvidence::kNone);
}
