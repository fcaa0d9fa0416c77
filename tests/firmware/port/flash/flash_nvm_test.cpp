// SPDX-License-Identifier: Apache-2.0
#include "port/flash/flash_nvm.hpp"

#include <array>
#include <cstdlib>
#include <vector>

#include "fake_flash.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port;
using test::Cut;
using test::FakeFlash;

namespace {

constexpr std::size_t kArea = 16 * 1024;
constexpr std::size_t kTripBytes = 8;
using Trip = std::array<std::uint8_t, kTripBytes>;
using Soc = std::vector<std::uint8_t>;

Trip trip(std::uint8_t mark) {
  Trip out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(mark + 31 * i);
  return out;
}
Soc soc(std::uint8_t mark) {
  Soc out(FlashNvm::kSocBytesMost);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(mark * 7 + i);
  return out;
}
Trip read_trip(FlashNvm& nvm, std::size_t slot) {
  Trip out{};
  nvm.read(NvmRecord::kTrips, slot, out.data(), out.size());
  return out;
}
Soc read_soc(FlashNvm& nvm, std::size_t slot) {
  Soc out(FlashNvm::kSocBytesMost);
  nvm.read(NvmRecord::kSoc, slot, out.data(), out.size());
  return out;
}
NvmResult write(FlashNvm& nvm, std::size_t slot, const Trip& bytes) {
  return nvm.write(NvmRecord::kTrips, slot, bytes.data(), bytes.size());
}
NvmResult write_whole(FlashNvm& nvm, std::size_t slot, const Soc& bytes) {
  NvmResult result = nvm.write(NvmRecord::kSoc, slot, bytes.data(), bytes.size());
  for (NvmResult step = NvmResult::kBusy; step == NvmResult::kBusy;) step = nvm.step();
  return result;
}
template <class Bytes>
bool blank(const Bytes& bytes) {
  for (const std::uint8_t b : bytes) {
    if (b != kFlashBlank) return false;
  }
  return true;
}

}  // namespace

TEST_GROUP(FlashNvm){};

TEST(FlashNvm, ANewMemoryIsBlankAndTakesRecordsThatARestartFinds) {
  for (const std::size_t unit : {4U, 8U}) {
    FakeFlash flash(unit, kArea, unit == 8);
    FlashNvm nvm(flash, 4);
    CHECK(nvm.prepare());
    CHECK(blank(read_trip(nvm, 0)) && blank(read_trip(nvm, 1)) && blank(read_soc(nvm, 0)));
    CHECK(write(nvm, 1, trip(3)) == NvmResult::kOk);
    CHECK(write_whole(nvm, 0, soc(9)) == NvmResult::kOk);
    CHECK(write(nvm, 1, trip(4)) == NvmResult::kOk);
    FlashNvm again(flash, 4);
    CHECK(again.prepare());
    CHECK(blank(read_trip(again, 0)));
    CHECK(trip(4) == read_trip(again, 1));
    CHECK(soc(9) == read_soc(again, 0));
    CHECK(!flash.programmed_twice);
  }
}

TEST(FlashNvm, ATripIsWrittenAtOnceWhileALongerRecordIsUnderWay) {
  FakeFlash flash(4, kArea, false);
  FlashNvm nvm(flash, 4);
  CHECK(nvm.prepare());
  const Soc long_one = soc(1);
  CHECK(nvm.write(NvmRecord::kSoc, 0, long_one.data(), long_one.size()) == NvmResult::kOk);
  CHECK(nvm.step() == NvmResult::kBusy);
  const std::uint64_t before = flash.operations;
  CHECK(write(nvm, 0, trip(1)) == NvmResult::kOk);
  CHECK(flash.operations - before <= 8);
  CHECK(trip(1) == read_trip(nvm, 0));
  CHECK(nvm.write(NvmRecord::kSoc, 1, long_one.data(), long_one.size()) == NvmResult::kBusy);
  int steps = 1;
  for (; nvm.step() == NvmResult::kBusy; ++steps) CHECK(blank(read_soc(nvm, 0)));
  LONGS_EQUAL((4 + FlashNvm::kSocBytesMost + 4 + 63) / 64, steps + 1);
  CHECK(long_one == read_soc(nvm, 0));
}

TEST(FlashNvm, AFullMemoryVoidsTheChargeRatherThanKeepAnOldOne) {
  FakeFlash flash(4, kArea, false);
  FlashNvm nvm(flash, 4);
  CHECK(nvm.prepare());
  const std::size_t room = nvm.left(NvmRecord::kSoc);
  CHECK(room >= 6);
  for (std::size_t i = 0; i < room; ++i) {
    CHECK(write_whole(nvm, i % 2, soc(static_cast<std::uint8_t>(i))) == NvmResult::kOk);
  }
  CHECK(!blank(read_soc(nvm, 0)));
  CHECK(write_whole(nvm, 0, soc(99)) == NvmResult::kFull);
  CHECK(write_whole(nvm, 1, soc(99)) == NvmResult::kFull);
  FlashNvm again(flash, 4);
  CHECK(again.prepare());
  CHECK(blank(read_soc(again, 0)) && blank(read_soc(again, 1)));
  CHECK(write_whole(again, 0, soc(5)) == NvmResult::kOk);
  CHECK(soc(5) == read_soc(again, 0));
}

TEST(FlashNvm, AFullMemoryOfTripsSaysSoAndKeepsTheLast) {
  FakeFlash flash(4, kArea, false);
  FlashNvm nvm(flash, 1);
  CHECK(nvm.prepare());
  for (std::size_t i = 0; i < FlashNvm::kTripEntries; ++i) {
    CHECK(write(nvm, i % 2, trip(static_cast<std::uint8_t>(i))) == NvmResult::kOk);
  }
  CHECK(write(nvm, 0, trip(99)) == NvmResult::kFull);
  CHECK(trip(63) == read_trip(nvm, 1));
  FlashNvm again(flash, 1);
  CHECK(again.prepare());
  LONGS_EQUAL(1, again.counts().moved);
  CHECK(trip(62) == read_trip(again, 0) && trip(63) == read_trip(again, 1));
  CHECK(write(again, 0, trip(64)) == NvmResult::kOk);
}

TEST(FlashNvm, AFlashThatRefusesAWriteIsTriedOnceMoreAndThenTold) {
  FakeFlash flash(4, kArea, false);
  FlashNvm nvm(flash, 4);
  CHECK(nvm.prepare());
  CHECK(write(nvm, 0, trip(1)) == NvmResult::kOk);
  flash.fail_every = 13;  // one of two entries fails
  for (std::uint8_t i = 2; i < 12; ++i) {
    CHECK(write(nvm, 0, trip(i)) == NvmResult::kOk);
    CHECK(trip(i) == read_trip(nvm, 0));
  }
  CHECK(nvm.counts().failed > 0);
  flash.dead = true;
  CHECK(write(nvm, 0, trip(50)) == NvmResult::kFailed);
  CHECK(trip(11) == read_trip(nvm, 0));
}

TEST(FlashNvm, AMemoryOfSomebodyElseIsNoTripThatNeverWas) {
  FakeFlash flash(4, kArea, false);
  for (std::size_t i = 0; i < kArea; ++i) flash.spoil(1, i, 0x12);
  for (int start = 0; start < 2; ++start) {
    FlashNvm nvm(flash, 4);
    CHECK(nvm.prepare());
    CHECK(!blank(read_trip(nvm, 0)));  // the keeper latches ConfigInvalid: nobody knows
    CHECK(blank(read_soc(nvm, 0)));
  }
  FlashNvm nvm(flash, 4);
  CHECK(nvm.prepare());
  CHECK(write(nvm, 0, trip(1)) == NvmResult::kOk);
  CHECK(trip(1) == read_trip(nvm, 0));
  CHECK(blank(read_trip(nvm, 1)) || !(trip(1) == read_trip(nvm, 1)));
}

TEST(FlashNvm, AMemoryThatIsTooSmallOrDeadIsRefused) {
  FakeFlash small(4, 4096, false);
  CHECK(!FlashNvm(small, 1).prepare());
  FakeFlash dead(4, kArea, false);
  dead.dead = true;
  FlashNvm nvm(dead, 1);
  CHECK(!nvm.prepare());
  CHECK(write(nvm, 0, trip(1)) == NvmResult::kFailed);
  CHECK(blank(read_trip(nvm, 0)));
}

TEST(FlashNvm, AFlashThatCanNoLongerBeErasedIsReadAndWrittenWhileItLasts) {
  FakeFlash flash(4, kArea, false);
  {
    FlashNvm nvm(flash, 4);
    CHECK(nvm.prepare());
    CHECK(write(nvm, 0, trip(7)) == NvmResult::kOk);
    for (std::uint8_t i = 5; i <= 7; ++i) CHECK(write_whole(nvm, 1, soc(i)) == NvmResult::kOk);
  }
  flash.dead = true;
  FlashNvm again(flash, 1000);  // it wants to move, and cannot
  CHECK(again.prepare());
  CHECK(trip(7) == read_trip(again, 0) && soc(7) == read_soc(again, 1));
  CHECK(again.counts().failed == 1 && again.counts().moved == 0);
  flash.dead = false;
  CHECK(write(again, 1, trip(8)) == NvmResult::kOk);
  CHECK(trip(8) == read_trip(again, 1) && trip(7) == read_trip(again, 0));
  CHECK(!flash.programmed_twice);
}

TEST(FlashNvm, WhatDoesNotFitIsRefused) {
  FakeFlash flash(4, kArea, false);
  FlashNvm nvm(flash, 1);
  CHECK(nvm.prepare());
  const Soc bytes(2000);
  CHECK(nvm.write(NvmRecord::kTrips, 0, bytes.data(), FlashNvm::kTripBytesMost + 1) == NvmResult::kFailed);
  CHECK(nvm.write(NvmRecord::kSoc, 0, bytes.data(), FlashNvm::kSocBytesMost + 1) == NvmResult::kFailed);
  CHECK(nvm.write(NvmRecord::kTrips, 2, bytes.data(), 8) == NvmResult::kFailed);
  CHECK(nvm.write(NvmRecord::kTrips, 0, bytes.data(), 0) == NvmResult::kFailed);
}

/// Every operation of a life of several starts, cut off in every way; then the memory is what it was before the write
/// that was cut off, or what that wrote. BMS-025, BMS-083
TEST(FlashNvm, ACutAtEveryUnitOfEveryWriteLeavesWhatWasOrWhatWasWritten) {
  std::uint64_t cuts = 0, old_ones = 0, new_ones = 0;
  for (const std::size_t unit : {4U, 8U}) {
    for (int how = 0; how < test::kCuts; ++how) {
      for (std::uint64_t at = 0;; ++at) {
        FakeFlash flash(unit, kArea, unit == 8);
        std::mt19937_64 draw(at * 31 + static_cast<std::uint64_t>(how));
        flash.draw = &draw;
        flash.cut_at = at;
        flash.cut = static_cast<Cut>(how);
        Trip before = trip(0), after = trip(0);
        before.fill(kFlashBlank);
        after = before;
        bool cut = false;
        try {
          for (std::uint8_t start = 0; start < 3; ++start) {
            FlashNvm nvm(flash, 5);  // the third start moves house
            nvm.prepare();
            for (std::uint8_t i = 0; i < 3; ++i) {
              after = trip(static_cast<std::uint8_t>(10 * start + i + 1));
              write(nvm, 0, after);
              before = after;
            }
            write_whole(nvm, 0, soc(start));
          }
        } catch (const stm32::test::PowerLost&) {
          cut = true;
        }
        CHECK(!flash.programmed_twice);
        if (!cut) break;
        ++cuts;
        flash.cut_at = UINT64_MAX;
        FlashNvm nvm(flash, 5);
        CHECK(nvm.prepare());
        const Trip found = read_trip(nvm, 0);
        const bool is_old = found == before, is_new = found == after;
        if (!is_old && !is_new) {  // only the very first may be unknown; then it is not blank
          CHECK(blank(before));
          CHECK(!blank(found));
        }
        (is_new ? new_ones : old_ones)++;
        CHECK(write(nvm, 0, trip(200)) == NvmResult::kOk);
        CHECK(trip(200) == read_trip(nvm, 0));
        CHECK(!flash.programmed_twice);
      }
    }
  }
  CHECK(cuts > 5000 && old_ones > 100 && new_ones > 100);
}
