// SPDX-License-Identifier: Apache-2.0
// SLCAN against lines that are right, cut, too long, drawn; and the rig of a board in lockstep behind it.
#include "port/serial/slcan.hpp"

#include <cstdlib>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "can_dbc/lockstep.hpp"
#include "port/serial/slcan_rig.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port;

namespace {

std::string line_of(const Frame& frame) {
  std::uint8_t line[Slcan::kLineMax];
  const std::size_t length = Slcan::encode(frame, line);
  return {line, line + length};
}

bool same(const Frame& a, const Frame& b) { return a.id == b.id && a.dlc == b.dlc && line_of(a) == line_of(b); }

bool is_of_a_bus(const Frame& frame) {
  const bool extended = (frame.id & Frame::kExtendedFlag) != 0;
  const bool fits = extended ? (frame.id & ~Frame::kExtendedFlag) <= 0x1FFF'FFFF : frame.id <= 0x7FF;
  bool padded = frame.dlc <= Frame::kMaxBytes;
  for (std::size_t i = frame.dlc; padded && i < Frame::kMaxBytes; ++i) padded = frame.data[i] == 0;
  return fits && padded;
}

constexpr char kLetters[] = "tTrRSOLCVNFZz0123456789ABCDEFabcdef\r\r\r\n\a ";

template <class Random>
char drawn_letter(Random& random) {
  return kLetters[random() % (sizeof kLetters - 1)];
}

/// A right line with up to two bytes changed, lost or put in.
template <class Random>
std::string damaged_line(Random& random) {
  Frame frame;
  frame.id = random() % 2 == 0 ? random() % 0x800U : random() % 0x2000'0000U | Frame::kExtendedFlag;
  frame.dlc = static_cast<std::uint8_t>(random() % 9);
  for (std::size_t i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
  std::string bytes = line_of(frame);
  for (std::uint32_t change = random() % 3; change > 0; --change) {
    const std::size_t at = random() % bytes.size();
    const std::uint32_t kind = random() % 3;
    if (kind == 0) bytes.erase(at, 1);
    if (kind == 1) bytes.insert(at, 1, drawn_letter(random));
    if (kind == 2) bytes[at] = static_cast<char>(random());
  }
  return bytes;
}

template <class Random>
std::string noise(Random& random) {
  std::string bytes;
  for (std::uint32_t left = random() % 60; left > 0; --left) {
    bytes += random() % 4 == 0 ? static_cast<char>(random()) : drawn_letter(random);
  }
  return bytes;
}

/// A line with a host at its other end; the board that is reset leaves by an exception.
struct Restarted {};
struct Silent {};
class FakeSerial final : public Serial {
 public:
  std::deque<std::uint8_t> in;
  std::string out;
  int silence_left = 1'000;

  void say(const std::string& text) { in.insert(in.end(), text.begin(), text.end()); }
  bool read(std::uint8_t& byte) override {
    if (in.empty() && --silence_left < 0) throw Silent{};
    if (in.empty()) return false;
    byte = in.front();
    in.pop_front();
    return true;
  }
  void write(std::uint8_t byte) override { out += static_cast<char>(byte); }
};
[[noreturn]] void reset_board() { throw Restarted{}; }

}  // namespace

TEST_GROUP(Slcan) {
  Slcan slcan;
  std::vector<Frame> frames;

  /// All answers to these bytes; frames are kept.
  std::string told(const std::string& bytes) {
    std::string answers;
    for (const char byte : bytes) {
      Frame frame;
      if (slcan.take(static_cast<std::uint8_t>(byte), frame)) frames.push_back(frame);
      answers += slcan.answer();
    }
    return answers;
  }
};

TEST(Slcan, AHostOpensAndClosesTheChannelAsSlcandDoes) {
  STRCMP_EQUAL("\a\r\r", told("C\rS6\rO\r").c_str());  // what is closed cannot be closed
  CHECK(slcan.is_open());
  STRCMP_EQUAL("\a\a", told("O\rS6\r").c_str());
  STRCMP_EQUAL("\r", told("C\r").c_str());
  CHECK_FALSE(slcan.is_open());
}

TEST(Slcan, OnlyTheBitRateOfTheBusIsTaken) {
  for (const char rate : std::string("01234578")) STRCMP_EQUAL("\a", told({'S', rate, '\r'}).c_str());
  STRCMP_EQUAL("\a\a\a\a", told("S\rS66\rs031C\rS9\r").c_str());
  STRCMP_EQUAL("\r", told("S6\r").c_str());
  LONGS_EQUAL(12, slcan.refused());
}

TEST(Slcan, QuestionsAreAnsweredAndErrorsToldOnce) {
  STRCMP_EQUAL("V0100\rNVL01\r\rF00\r", told("V\rN\rZ0\rF\r").c_str());
  STRCMP_EQUAL("\aF08\rF00\r", told("Z1\rF\rF\r").c_str());
}

TEST(Slcan, FramesOfBothKindsComeAndGoAsTheyAre) {
  const Frame sent[] = {{0x7FF, 0, {}},
                        {0x0C1, 8, {0x4F, 0xC3, 3, 0, 0, 0, 0x66, 0x1D}},
                        {0x18DA'B0F1U | Frame::kExtendedFlag, 3, {2, 0x11, 1}},
                        {Frame::kExtendedFlag, 1, {0xFF}}};
  STRCMP_EQUAL("t0C184FC303000000661D\r", line_of(sent[1]).c_str());
  STRCMP_EQUAL("T18DAB0F13021101\r", line_of(sent[2]).c_str());
  told("O\r");
  std::string lines;
  for (const Frame& frame : sent) lines += line_of(frame);
  STRCMP_EQUAL("z\rz\rZ\rZ\r", told(lines).c_str());
  LONGS_EQUAL(4, frames.size());
  for (std::size_t i = 0; i < 4; ++i) CHECK(same(sent[i], frames[i]));
}

TEST(Slcan, SmallLettersAndBothLineEndsAreRead) {
  told("O\r\n");
  STRCMP_EQUAL("z\r", told("t0c11ab\r\n").c_str());
  LONGS_EQUAL(0xAB, frames[0].data[0]);
}

TEST(Slcan, AFrameIsRefusedWhileClosedOrListening) {
  STRCMP_EQUAL("\a", told("t0C10\r").c_str());
  STRCMP_EQUAL("\r\a", told("L\rt0C10\r").c_str());
  LONGS_EQUAL(0, frames.size());
}

TEST(Slcan, WhatIsNoFrameOfTheBusIsRefused) {
  told("O\r");
  for (const char* line : {"t0C1\r", "t0C12AB\r", "t0C11ABC\r", "t0C11ABCD\r", "t0C19000000000000000000\r", "t8001FF\r",
                           "t0G11FF\r", "t0C11 F\r", "T200000001FF\r", "T18DAB0F\r", "r0C10\r", "R000000010\r", "x\r",
                           "\a\r"}) {
    STRCMP_EQUAL("\a", told(line).c_str());
  }
  LONGS_EQUAL(0, frames.size());
  STRCMP_EQUAL("", told("\r\r").c_str());  // what a host sends to begin with a clean line
}

TEST(Slcan, ALineComesInPiecesAndOneTooLongIsLeftOutWhole) {
  told("O\r");
  STRCMP_EQUAL("", told("t0C1").c_str());
  STRCMP_EQUAL("z\r", told("1FF\r").c_str());
  STRCMP_EQUAL("\a", told(std::string(10'000, 't') + "t0C11FF\r").c_str());
  STRCMP_EQUAL("z\r", told("t0C11FE\r").c_str());
  LONGS_EQUAL(2, frames.size());
}

TEST(Slcan, NoiseIsNeverAFrameThatNoBusCarriesAndTheNextLineIsRead) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const auto seed = given == nullptr ? std::random_device{}()
                                     : static_cast<std::uint32_t>(std::strtoul(given, nullptr, 10));
  const std::string told_seed = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
  std::mt19937 engine(seed);
  const auto random = [&engine] { return static_cast<std::uint32_t>(engine()); };
  for (int round = 0; round < 20'000; ++round) {
    const std::string bytes = round % 2 == 0 ? damaged_line(random) : noise(random);
    frames.clear();
    told("\rC\rO\r" + bytes);
    for (const Frame& frame : frames) {
      CHECK_TEXT(is_of_a_bus(frame), told_seed.c_str());
    }
    frames.clear();
    told("\rC\rO\r");  // what is left of a line may be a frame
    frames.clear();
    told("t0C11A5\r");
    CHECK_TEXT(frames.size() == 1 && frames[0].data[0] == 0xA5, told_seed.c_str());
  }
}

TEST_GROUP(SlcanRig) {
  FakeSerial serial;
  std::uint8_t bytes[4 * kFrameBytes] = {};

  std::string sync_line() {
    can::Sync sync;
    Frame frame;
    encode(sync, frame);
    return line_of(frame);
  }
};

TEST(SlcanRig, SaysNothingBeforeTheChannelIsOpenAndThenThatItIsReadyUntilItIsStepped) {
  SlcanRig rig(serial, reset_board, 10);
  frame_to_bytes({0x7E1, 1, {1}}, bytes);
  serial.say("S6\rO\r");
  CHECK(rig.write(bytes, kFrameBytes));
  STRCMP_EQUAL("\r\rt7E1101\r", serial.out.c_str());
  serial.out.clear();
  serial.silence_left = 25;
  CHECK_THROWS(Silent, rig.read(bytes, sizeof bytes));
  STRCMP_EQUAL("t7E1101\rt7E1101\r", serial.out.c_str());
  serial.say("t0C11FF\r" + sync_line());
  LONGS_EQUAL(kFrameBytes, rig.read(bytes, sizeof bytes));
  Frame frame;
  CHECK(frame_from_bytes(bytes, frame));
  LONGS_EQUAL(0xFF, frame.data[0]);
  LONGS_EQUAL(kFrameBytes, rig.read(bytes, sizeof bytes));
  serial.out.clear();
  serial.silence_left = 1'000;
  CHECK_THROWS(Silent, rig.read(bytes, sizeof bytes));
  STRCMP_EQUAL("", serial.out.c_str());
}

TEST(SlcanRig, TheEndOfARunIsAResetForTheNextOne) {
  SlcanRig rig(serial, reset_board, 10);
  CHECK_THROWS(Restarted, rig.end(true));
  CHECK_FALSE(rig.counts());
}
