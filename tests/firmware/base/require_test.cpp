// SPDX-License-Identifier: Apache-2.0
#include "base/require.hpp"

#include <csetjmp>
#include <cstring>

#include "CppUTest/TestHarness.h"

namespace {
std::jmp_buf back;
const char* failed_condition = nullptr;
}  // namespace

// A port's own safe state takes the place of the default.
void voltlap::require_failed(const char* condition, const char* /*file*/, int /*line*/) {
  failed_condition = condition;
  std::longjmp(back, 1);
}

TEST_GROUP(Require) {
  void setup() override { failed_condition = nullptr; }
};

TEST(Require, TrueConditionGoesOn) {
  VOLTLAP_REQUIRE(1 + 1 == 2);
  POINTERS_EQUAL(nullptr, failed_condition);
}

TEST(Require, FalseConditionDrivesTheSafeStateAndNamesItself) {
  if (setjmp(back) == 0) {
    VOLTLAP_REQUIRE(1 + 1 == 3);
    FAIL("went on");
  }
  STRCMP_EQUAL("1 + 1 == 3", failed_condition);
}
