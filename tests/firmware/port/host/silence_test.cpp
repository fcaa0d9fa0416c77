// SPDX-License-Identifier: Apache-2.0
#include "port/host/silence.hpp"

#include <thread>

#include <CppUTest/TestHarness.h>

using voltlap::port::Silence;

TEST_GROUP(Silence) {
  Silence silence;

  void pass(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
};

TEST(Silence, BeginsWithTheFirstWaitThatWasInVain) {
  pass(50);
  DOUBLES_EQUAL(0.0, silence.go_on(), 1e-12);
  pass(50);
  CHECK(silence.go_on() >= 0.05);
}

TEST(Silence, EndsWithAWord) {
  static_cast<void>(silence.go_on());
  pass(50);
  silence.end();
  DOUBLES_EQUAL(0.0, silence.go_on(), 1e-12);
}
