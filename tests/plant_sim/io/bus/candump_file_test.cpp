// SPDX-License-Identifier: Apache-2.0
#include "io/bus/candump_file.hpp"

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(CandumpFile) {};

TEST(CandumpFile, LineHasSimulatedTimeBusIdAndData) {
  Frame f{.id = 0x44, .dlc = 2, .data = {0x2A, 0x36}};
  STRCMP_EQUAL("(12.340000) vcan0 044#2A36", candump_line(12340, f).c_str());
}

TEST(CandumpFile, ExtendedIdHasEightDigits) {
  Frame f{.id = Frame::kExtendedFlag | 0x123, .dlc = 1, .data = {0x0F}};
  STRCMP_EQUAL("(0.005000) vcan0 00000123#0F", candump_line(5, f).c_str());
}

TEST(CandumpFile, FrameWithoutDataEndsAfterTheHash) {
  STRCMP_EQUAL("(0.000000) vcan0 7FF#", candump_line(0, Frame{.id = 0x7FF}).c_str());
}

TEST(CandumpFile, FramesStandInOrderOfSending) {
  const Scratch scratch;
  CandumpFile file(scratch.file("log"), 10);
  file.on_frame(1, Sender::kPlant, Frame{.id = 1});
  file.on_frame(1, Sender::kBms, Frame{.id = 2});
  file.commit();
  std::ifstream in(scratch.file("log"));
  std::string first, second;
  std::getline(in, first);
  std::getline(in, second);
  STRCMP_EQUAL("(0.010000) vcan0 001#", first.c_str());
  STRCMP_EQUAL("(0.010000) vcan0 002#", second.c_str());
}
