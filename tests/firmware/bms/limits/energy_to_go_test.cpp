// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/energy_to_go.hpp"

#include <cstdlib>
#include <random>
#include <utility>

#include "bench.hpp"
#include "bms/limits/limits.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::LimitReason;

namespace {

constexpr int kPieces = 220;  // of 22 km

Config spreading() {
  Config c = pack_config();
  c.energy_to_go_m = 22'000;
  c.um_per_motor_turn = 400'000;
  return c;
}

/// Drives piece after piece: in each a peak of current and some charge, both as much as the limit leaves of them.
struct Drive {
  Config config = spreading();
  State s{};
  double soc = 1.0;
  double peak_a = 300.0, base = 0.0;  ///< current of an unlimited piece; charge of it
  double with_limit = 0.7;            ///< share of the charge that falls with the limit
  int driven = 0;

  Drive() {
    s.soc.valid = true;
    s.measured.current.quality = s.measured.motor_speed.quality = Quality::kGood;
    s.measured.motor_speed.value = MotorSpeed::from_raw(3'000);  // 20 m/s
    s.contactors.state = can::BmsState::kTsActive;
    tell();
  }
  void tell() { s.soc.value = Soc::from_raw(static_cast<std::int32_t>(1e6 * (soc > 0.0 ? soc : 0.0))); }
  [[nodiscard]] Current cap() const { return s.energy_to_go.cap; }
  [[nodiscard]] double limit_a() const { return cap() > Current{} ? 1e-3 * cap().raw() : 500.0; }

  void piece(double taken, double current_a) {
    s.measured.current.value = amps(current_a);
    for (int k = 0; k < 50; ++k) {
      soc -= taken / 50;
      tell();
      spread_charge(config, Duration::from_ms(100), s);
    }
    s.measured.current.value = Current{};
    ++driven;
  }
  void by_limit(double hunger = 1.0) {
    const double share = std::min(1.0, limit_a() / peak_a);
    piece(hunger * base * (1.0 - with_limit + with_limit * share), std::min(peak_a, limit_a()));
  }
};

unsigned seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : std::random_device{}();
}

}  // namespace

TEST_GROUP(EnergyToGo) {
  Drive drive;
};

// BMS-048
TEST(EnergyToGo, SwitchedOffItLimitsNothing) {
  drive.config.energy_to_go_m = 0;
  drive.base = 0.02;
  for (int k = 0; k < 60; ++k) drive.by_limit();
  CHECK(drive.cap() == Current{});
  LONGS_EQUAL(0, drive.s.energy_to_go.pieces);
}

// BMS-048: what lasts is not touched.
TEST(EnergyToGo, APackThatLastsIsNotLimited) {
  drive.base = 0.9 / kPieces;
  for (int k = 0; k < kPieces; ++k) {
    drive.by_limit();
    CHECK(drive.cap() == Current{});
  }
}

// BMS-048: drawn packs, drivers and cars.
TEST(EnergyToGo, APackThatIsTooSmallComesHomeWithItsReserve) {
  const unsigned drawn = seed();
  std::printf("VOLTLAP_TEST_SEED=%u\n", drawn);
  std::mt19937 random(drawn);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  double worst_low = 1.0, worst_high = 0.0;
  for (int k = 0; k < 60; ++k) {
    Drive car;
    const double start = 0.6 + 0.4 * uniform(random), shortage = 1.02 + 0.33 * uniform(random),
                 spread = 0.3 * uniform(random);
    car.soc = start;
    car.base = shortage * (start - 0.03) / kPieces;
    car.peak_a = 100.0 + 380.0 * uniform(random);
    car.with_limit = 0.6 + 0.35 * uniform(random);
    while (car.driven < kPieces) car.by_limit(1.0 + spread * (2.0 * uniform(random) - 1.0));
    worst_low = std::min(worst_low, car.soc);
    worst_high = std::max(worst_high, car.soc);
    CHECK_TEXT(car.soc > 0.019, "the reserve of 3 % is used up");
    CHECK_TEXT(car.soc < 0.041, "charge was left that could have been used");
  }
  std::printf("BMS-048: left after 22 km %.2f to %.2f %% (reserve 3 %%)\n", 100 * worst_low, 100 * worst_high);
}

// BMS-048
TEST(EnergyToGo, TheLimitSaysWhyItIsLow) {
  drive.base = 1.5 / kPieces;
  while (drive.cap() == Current{}) drive.by_limit();
  CHECK(drive.cap() <= amps(300));
  Limit limit{amps(500), LimitReason::kConfigMaximum, kNoCell};
  lower_discharge_by_energy(drive.s, limit);
  CHECK(limit.value == drive.cap() && limit.reason == LimitReason::kEnergyToGo);
  Limit lower_one{amps(1), LimitReason::kTemperature, kNoCell};
  lower_discharge_by_energy(drive.s, lower_one);
  CHECK(lower_one.reason == LimitReason::kTemperature);
}

// BMS-048: it begins at what is driven, and moves by little.
TEST(EnergyToGo, TheCapBeginsAtTheCurrentOfLateAndMovesSlowly) {
  drive.base = 1.4 / kPieces;
  while (drive.cap() == Current{}) drive.by_limit();
  CHECK(drive.cap() == amps(300));
  double last = drive.limit_a();
  while (drive.driven < kPieces - 1) {
    drive.by_limit();
    CHECK(drive.limit_a() < last * 1.032 && drive.limit_a() > last * 0.968);
    last = drive.limit_a();
  }
}

// BMS-048
TEST(EnergyToGo, WithTheReserveUsedUpATenthIsLeftToComeHomeWith) {
  drive.base = 3.0 / kPieces;
  drive.with_limit = 0.0;
  while (drive.driven < kPieces - 1) drive.by_limit();
  CHECK(drive.cap() == amps(30));
  drive.by_limit();
  CHECK(drive.cap() == Current{});  // 22 km are driven
}

// BMS-048: a driver who has learned to save gets the current back.
TEST(EnergyToGo, TheCapEndsWhenItIsFarAboveWhatIsDriven) {
  drive.base = 1.3 / kPieces;
  while (drive.driven < 30) drive.by_limit();
  CHECK(drive.cap() > Current{});
  drive.peak_a = 120.0;
  drive.base = 0.5 / kPieces;
  while (drive.cap() > Current{} && drive.driven < 200) drive.by_limit();
  CHECK(drive.driven < 200);
  for (int k = 0; k < 10; ++k) drive.by_limit();
  CHECK(drive.cap() == Current{});
}

// BMS-048: more at the wheel is more of the way, whichever way the motor turns.
TEST(EnergyToGo, TheWayIsTheMotorsTurns) {
  drive.piece(0.001, 100.0);
  LONGS_EQUAL(1, drive.s.energy_to_go.pieces);
  drive.s.measured.motor_speed.value = MotorSpeed::from_raw(-6'000);
  drive.piece(0.001, 100.0);
  LONGS_EQUAL(3, drive.s.energy_to_go.pieces);
  drive.s.measured.motor_speed.quality = Quality::kInvalid;
  drive.piece(0.001, 100.0);
  LONGS_EQUAL(3, drive.s.energy_to_go.pieces);
}

// BMS-048
TEST(EnergyToGo, AChargeBeginsTheWayAnew) {
  drive.base = 1.5 / kPieces;
  while (drive.driven < 60) drive.by_limit();
  CHECK(drive.cap() > Current{});
  drive.s.contactors.state = can::BmsState::kCharging;
  spread_charge(drive.config, Duration::from_ms(10), drive.s);
  CHECK(drive.cap() == Current{});
  LONGS_EQUAL(0, drive.s.energy_to_go.pieces);
}

// BMS-048, BMS-083: a supply that fails in mid-race does not begin the way anew, a charge meanwhile does.
TEST(EnergyToGo, ARestartGoesOnWithTheWayThatIsLeft) {
  drive.soc = 0.6;
  drive.tell();
  SocRecord record;
  record.cells = 24;
  record.pieces = 110;
  for (CellRecord& cell : record.cell) cell.soc = static_cast<std::int16_t>(0.6 * (1 << 14));
  restore_way(record, drive.s.energy_to_go);
  drive.piece(0.001, 100.0);
  LONGS_EQUAL(111, drive.s.energy_to_go.pieces);
  Drive charged;
  charged.soc = 0.66;
  charged.tell();
  restore_way(record, charged.s.energy_to_go);
  charged.piece(0.001, 100.0);
  LONGS_EQUAL(1, charged.s.energy_to_go.pieces);
  Drive blank;
  restore_way(SocRecord{}, blank.s.energy_to_go);
  blank.piece(0.001, 100.0);
  LONGS_EQUAL(1, blank.s.energy_to_go.pieces);
}

namespace {

/// The end of a piece on a state made by hand: 0.4 % taken in each of the last ten, 119 pieces left behind it.
struct OnePiece {
  Drive drive;
  EnergyToGo& e = drive.s.energy_to_go;
  OnePiece() {
    e = EnergyToGo{};
    e.began = true;
    e.pieces = 100;
    e.seen = 10;
    e.taken = 4'000 << 8;
    e.at_mark = Soc::from_raw(600'000);
    e.peak = e.began_at = amps(200);
    e.cap = amps(100);
    e.way = std::int64_t{100} * 1'000'000 * 60'000 - 1;
    drive.s.measured.current.value = Current{};
  }
  OnePiece& ends_at(std::int32_t soc) {
    drive.s.soc.value = Soc::from_raw(soc);
    spread_charge(drive.config, Duration::from_ms(10), drive.s);
    return *this;
  }
};

}  // namespace

// BMS-048: r = (596 000 - 30 000) / 119 / 4 000 = 1.19, a sixteenth of it.
TEST(EnergyToGo, APieceMovesTheCapByASixteenthOfWhatIsLeft) {
  OnePiece piece;
  piece.ends_at(596'000);
  LONGS_EQUAL(101'177, piece.e.cap.raw());
  LONGS_EQUAL(101, piece.e.pieces);
  LONGS_EQUAL(4'000 << 8, piece.e.taken);
  LONGS_EQUAL(596'000, piece.e.at_mark.raw());
  LONGS_EQUAL(190'000, piece.e.peak.raw());
}

// BMS-048: the mean of ten, and what counts in it.
TEST(EnergyToGo, WhatIsTakenIsTheMeanOfTenPieces) {
  OnePiece piece;
  piece.ends_at(595'000);
  LONGS_EQUAL((4'000 << 8) + (1'000 << 8) / 10, piece.e.taken);
  LONGS_EQUAL(10, piece.e.seen);
  OnePiece ninth;
  ninth.e.seen = 8;
  ninth.ends_at(595'000);
  LONGS_EQUAL((4'000 << 8) + (1'000 << 8) / 9, ninth.e.taken);
  OnePiece first;
  first.e = EnergyToGo{};
  first.e.way = std::int64_t{100} * 1'000'000 * 60'000 - 1;
  first.drive.s.soc.value = Soc::from_raw(600'000);
  first.drive.s.measured.motor_speed.quality = Quality::kInvalid;
  spread_charge(first.drive.config, Duration::from_ms(10), first.drive.s);
  first.drive.s.measured.motor_speed.quality = Quality::kGood;
  first.ends_at(598'000);
  LONGS_EQUAL(2'000 << 8, first.e.taken);
}

// BMS-048: no more than 3.1 % a piece either way, and where nothing was taken as much as can be.
TEST(EnergyToGo, TheRatioIsHeldWithinAHalfAndThreeHalves) {
  OnePiece plenty;
  plenty.e.taken = 40 << 8;
  plenty.ends_at(599'960);
  LONGS_EQUAL(103'125, plenty.e.cap.raw());
  OnePiece nothing;
  nothing.e.taken = 0;
  nothing.ends_at(600'000);
  LONGS_EQUAL(103'125, nothing.e.cap.raw());
  OnePiece little;
  little.ends_at(40'000);
  LONGS_EQUAL(96'875, little.e.cap.raw());
}

// BMS-048
TEST(EnergyToGo, WhatIsTakenExactlyAsAllowedMovesAndBeginsNothing) {
  OnePiece moves;
  moves.e.at_mark = Soc::from_raw(510'000);
  moves.e.peak = amps(10);
  moves.ends_at(506'000);  // 476 000 / 119 = 4 000
  LONGS_EQUAL(100'000, moves.e.cap.raw());
  OnePiece begins;
  begins.e.at_mark = Soc::from_raw(510'000);
  begins.e.cap = Current{};
  begins.ends_at(506'000);
  LONGS_EQUAL(0, begins.e.cap.raw());
}

// BMS-048: with enough left, at the maximum or a quarter above what is driven; never with too little.
TEST(EnergyToGo, TheCapEndsAtTheMaximumOrAQuarterAboveWhatIsDriven) {
  const auto ended = [](std::int32_t cap, std::int32_t peak, std::int32_t soc = 596'000) {
    OnePiece piece;
    piece.e.cap = Current::from_raw(cap);
    piece.e.peak = Current{};
    piece.e.piece_peak = Current::from_raw(peak);
    return piece.ends_at(soc).e.cap == Current{};
  };
  CHECK(ended(494'179, 450'000));  // 500 A, the maximum
  CHECK_FALSE(ended(494'178, 450'000));
  CHECK(ended(100'000, 80'941));  // 101.177 A
  CHECK_FALSE(ended(100'000, 80'942));
  CHECK_FALSE(ended(99'998, 80'940));  // 101.175 A, a quarter and no more
  CHECK_FALSE(ended(100'000, 10'000, 40'000));
}

// BMS-048
TEST(EnergyToGo, ThePeakIsThatOfThePieceAndFades) {
  OnePiece piece;
  piece.e.piece_peak = amps(195);
  piece.ends_at(596'000);
  LONGS_EQUAL(195'000, piece.e.peak.raw());
  LONGS_EQUAL(0, piece.e.piece_peak.raw());
  piece.drive.s.measured.current.value = amps(400);
  piece.drive.s.measured.current.quality = Quality::kInvalid;
  spread_charge(piece.drive.config, Duration::from_ms(10), piece.drive.s);
  LONGS_EQUAL(0, piece.e.piece_peak.raw());
}

// BMS-048
TEST(EnergyToGo, WhatIsDrivenBeyondAllCountsEndsNothing) {
  OnePiece piece;
  piece.e.pieces = kPiecesMost;
  piece.ends_at(596'000);
  LONGS_EQUAL(kPiecesMost, piece.e.pieces);
  LONGS_EQUAL(0, piece.e.cap.raw());
}

// BMS-048
TEST(EnergyToGo, FivePointsMoreThanTheRecordAreACharge) {
  SocRecord record;
  record.cells = 24;
  record.pieces = 110;
  for (CellRecord& cell : record.cell) cell.soc = 8'192;  // half
  for (const auto& [soc, pieces] : {std::pair{550'000, 110}, {550'001, 0}}) {
    Drive car;
    car.s.soc.value = Soc::from_raw(soc);
    restore_way(record, car.s.energy_to_go);
    car.s.measured.motor_speed.value = MotorSpeed{};
    spread_charge(car.config, Duration::from_ms(10), car.s);
    LONGS_EQUAL(pieces, car.s.energy_to_go.pieces);
  }
}

// BMS-048: before the state of charge is known nothing is counted.
TEST(EnergyToGo, WithoutAStateOfChargeNothingIsCounted) {
  drive.s.soc.valid = false;
  drive.piece(0.5, 300.0);
  LONGS_EQUAL(0, drive.s.energy_to_go.pieces);
  CHECK(drive.cap() == Current{});
}
