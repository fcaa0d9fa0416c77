// SPDX-License-Identifier: Apache-2.0
// Drawn packs on a charger, with the firmware in the loop: no cell above its greatest voltage at any time, all even at
// the end, and no shunt on with the shutdown circuit open.
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "charge/charge_run.hpp"
#include "charge/charge_text.hpp"
#include "charge/drawn_cells.hpp"
#include "core/parameter_file.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

struct Watching : ChargeObserver {
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const ChargeSample& sample) override { samples.push_back(sample); }
  bool stop_requested() override { return false; }
  std::vector<ChargeSample> samples;
};

ChargeOptions standing(double soc) {
  ChargeOptions options;
  options.vehicle = vtm16e();
  options.vehicle.battery.initial_soc = soc;
  return options;
}

ChargeResult charge(const ChargeOptions& options) {
  FirmwareLoop firmware(options.vehicle);
  InProcessLoop bus(firmware);
  Watching watching;
  return run_charge(options, bus, watching);
}

/// Nearly full, and one cell so far above the others that it is bled soon.
ChargeOptions with_a_high_cell() {
  ChargeOptions options = standing(0.985);
  options.vehicle.battery.cells.resize(3);
  options.vehicle.battery.cells[2].initial_soc_offset = 0.012;
  options.ticks_per_step = 1;  // shunts and contactors move within their tick
  return options;
}

}  // namespace

TEST_GROUP(ChargedPack) {
  const std::uint64_t seed = drawn_seed();
  Drawn draw{seed};

  void expect_full(const ChargeResult& r, double greatest_v) {
    const std::string told =
        fmt::format("VOLTLAP_TEST_SEED={} ({}; {:.4f} V at most, {:.1f} mV at the end, {:.1f} h)", seed,
                    ending_words(r), r.highest_cell_v, 1e3 * r.end_spread_v(), r.time_s / 3600.0);
    CHECK_TEXT(r.full, told.c_str());
    CHECK_TEXT(r.faults == 0, told.c_str());
    CHECK_TEXT(r.highest_cell_v <= greatest_v, told.c_str());
    CHECK_TEXT(r.end_spread_v() < 0.005, told.c_str());
    CHECK_TEXT(r.end_soc_min > 0.97, told.c_str());
    CHECK_TEXT(r.bled_open_s == 0.0, told.c_str());
  }
};

// BMS-052
TEST(ChargedPack, DrawnCellsFromATenthOnBecomeFullAndEven) {
  ChargeOptions options = standing(0.1);
  draw_cells({.soc = 0.005, .capacity = 0.004, .resistance = 0.15}, seed, options.vehicle);
  expect_full(charge(options), 4.2);
}

// BMS-052
TEST(ChargedPack, NoisySensorsAndAnEarlierStartChangeNothing) {
  ChargeOptions options = standing(draw.between(0.7, 0.9));
  options.vehicle.sensors.noise = options.vehicle.sensors.quantisation = true;
  options.vehicle.bms.soc_method = draw.chance(0.5) ? "ekf" : "coulomb";
  const bool ahead = options.vehicle.bms.soc_method == "ekf" && draw.chance(0.5);
  options.vehicle.bms.limit_method = ahead ? "ahead" : (draw.chance(0.5) ? "table" : "equation");
  options.seed = seed;
  draw_cells({.soc = 0.0015, .capacity = 0.002, .resistance = 0.2}, seed, options.vehicle);
  const ChargeResult r = charge(options);
  expect_full(r, 4.2);
  CHECK_TEXT(r.charging_s < 3.0 * 3600.0, "the highest of noisy readings holds the charge");
}

// BMS-061
TEST(ChargedPack, AWeakCellAccusesNoChannel) {
  ChargeOptions options = standing(0.1);
  options.vehicle.battery.cells.resize(7);
  options.vehicle.battery.cells[6].capacity_scale = 0.85;
  options.vehicle.battery.cells[6].resistance_scale = 1.4;
  options.vehicle.bms.balancing_time_max_s = 600.0;  // the cells of so different a pack take days
  const ChargeResult r = charge(options);
  CHECK(r.reason == can::ChargeReason::kBalancingTime);
  LONGS_EQUAL(0, r.faults);
  CHECK(r.highest_cell_v <= 4.2);
}

TEST(ChargedPack, ASmallChargerFillsThePackToo) {
  ChargeOptions options = standing(0.97);
  options.vehicle.charger.current_max_a = 1.0;  // less than the 1.1 A at which a cell counts as full
  const ChargeResult r = charge(options);
  expect_full(r, 4.2);
  CHECK(r.charging_s > 3600.0);
}

// BMS-050
TEST(ChargedPack, AShutdownCircuitThatOpensWhileCellsAreBledEndsItAtOnce) {
  ChargeOptions options = with_a_high_cell();
  double opened_s = -1.0, ended_s = -1.0;
  options.hand = [&](const ChargeHand& hand) {
    if (opened_s < 0.0 && !hand.car.pack().bleeding().empty() && hand.time_s > 100.0) opened_s = hand.time_s;
    if (opened_s < 0.0) return;
    hand.shutdown_closed = false;
    if (ended_s < 0.0 && hand.car.pack().bleeding().empty()) ended_s = hand.time_s;
  };
  const ChargeResult r = charge(options);
  CHECK(opened_s > 0.0 && ended_s > 0.0);
  CHECK(r.phase == can::ChargePhase::kStopped && r.reason == can::ChargeReason::kShutdownCircuit);
  std::printf("BMS-050 in the loop: %.0f ms after the opening no shunt is on\n", 1e3 * (ended_s - opened_s));
  CHECK(ended_s - opened_s <= 0.1);
  CHECK(r.bled_open_s <= 0.1);
}

// BMS-053
TEST(ChargedPack, AChargerThatFallsSilentIsLeft) {
  ChargeOptions options = standing(0.5);
  double silent_s = -1.0, open_s = -1.0;
  options.hand = [&](const ChargeHand& hand) {
    if (hand.time_s < 60.0) return;
    hand.faults.charger_silent = true;
    if (silent_s < 0.0) silent_s = hand.time_s;
    if (open_s < 0.0 && !hand.car.contactors.air_plus.closed()) open_s = hand.time_s;
  };
  const ChargeResult r = charge(options);
  CHECK(r.reason == can::ChargeReason::kChargerSilent && open_s > 0.0);
  std::printf("BMS-053 in the loop: contactors open %.0f ms after the silence\n", 1e3 * (open_s - silent_s));
  CHECK(open_s - silent_s <= 3.3);  // and 0.3 s of the plant's steps and the contactor
}

// BMS-054
TEST(ChargedPack, AChargerThatObeysNoMoreIsLeft) {
  ChargeOptions options = standing(0.8);
  double asked_less_s = -1.0, open_s = -1.0;
  options.hand = [&](const ChargeHand& hand) {
    // Nothing is told to it any more: it stays at its current while the cells come to their end.
    if (hand.time_s > 60.0) hand.car.charger.ignores_commands = true;
    if (asked_less_s < 0.0 && hand.time_s > 60.0) asked_less_s = hand.time_s;
    if (open_s < 0.0 && hand.time_s > 61.0 && !hand.car.contactors.air_plus.closed()) open_s = hand.time_s;
  };
  const ChargeResult r = charge(options);
  STRCMP_EQUAL("CurrentNotAsked", reason_name(r.reason));
  CHECK(open_s > 0.0);
  CHECK(r.highest_cell_v <= 4.2);
}

TEST(ChargedPack, ATargetBelowFullIsTheSwitchsOff) {
  ChargeOptions options = standing(0.3);
  options.to_soc = 0.4;
  const ChargeResult r = charge(options);
  CHECK(r.reached && !r.full);
  DOUBLES_EQUAL(0.4, r.end_soc, 0.005);
}

// BMS-056
TEST(ChargedPack, DrawnCellsPacksAndChargersEndFullOrByName) {
  for (int k = 0; k < 3; ++k) {
    const int series = k == 0 ? 72 : draw.whole(6, 144);  // 72 of the small cells had gone on for ever
    const char* const cells[] = {"molicel_p42a", "molicel_p45b", "samsung_30q", "sony_vtc6", "lg_m50lt"};
    const char* const limits[] = {"equation", "table"};
    const std::vector<std::string> settings = {
        fmt::format("battery.cell={}", cells[k == 0 ? 0 : draw.whole(0, 4)]),
        fmt::format("battery.cells_in_series={}", series),
        fmt::format("battery.cells_in_parallel={}", k == 0 ? 1 : draw.whole(1, 4)),
        fmt::format("sensors.temperature_count={}", series / 5 + 1),
        fmt::format("bms.soc_method={}", draw.chance(0.5) ? "coulomb" : "none"),
        fmt::format("bms.limit_method={}", limits[draw.whole(0, 1)]),
        fmt::format("bms.charger_current_max_a={:.1f}", draw.between(0.5, 10.0)),
        fmt::format("battery.initial_temperature_c={:.0f}", draw.between(5.0, 45.0)),
        fmt::format("battery.initial_soc={:.3f}", draw.between(0.97, 0.995))};
    ChargeOptions options;
    options.vehicle = load_vehicle(DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data"), "vtm16e", settings).parameters;
    options.seed = seed;
    options.duration_max_s = 30.0 * 3600.0;
    draw_cells({.soc = 0.001, .capacity = 0.0, .resistance = 0.05}, seed, options.vehicle);
    const ChargeResult r = charge(options);
    const std::string told = fmt::format("VOLTLAP_TEST_SEED={} draw {} ({}; {} after {:.1f} h)", seed, k,
                                         fmt::join(settings, " "), ending_words(r), r.time_s / 3600.0);
    CHECK_TEXT(r.full || r.phase == can::ChargePhase::kStopped, told.c_str());
    CHECK_TEXT(r.full || r.reason != can::ChargeReason::kNone, told.c_str());
    CHECK_TEXT(r.highest_cell_v <= 4.2, told.c_str());
  }
}

// BMS-058, BMS-089
TEST(ChargedPack, ALeakingCellIsNamedAndThePackIsLeftFullAndCountedSo) {
  ChargeOptions options = standing(0.9);
  options.vehicle.battery.cells.resize(12);
  options.vehicle.battery.cells[11].initial_soc_offset = -0.05;
  options.vehicle.battery.cells[11].leak_a = 0.13 / options.vehicle.battery.cells_in_parallel;  // as much as a shunt
  const ChargeResult r = charge(options);
  CHECK(r.reason == can::ChargeReason::kUneven);
  LONGS_EQUAL(11, r.off_cell);
  CHECK(r.end_soc > 0.97);
  DOUBLES_EQUAL(r.end_soc, r.bms_soc, 0.01);
  CHECK(r.bleeding_s < 4.0 * 3600.0);
}

TEST(ChargedPack, CellsThatAreTooColdInColdAirAreSaidAtOnce) {
  ChargeOptions options = standing(0.5);
  options.vehicle.battery.initial_temperature_c = options.vehicle.environment.ambient_c = -5.0;
  const ChargeResult r = charge(options);
  CHECK(r.idle && r.too_cold && r.reason == can::ChargeReason::kTemperature && r.time_s < 60.0);
}

TEST(ChargedPack, CellsThatAreTooColdInWarmAirAreWaitedFor) {
  ChargeOptions options = standing(0.5);
  options.to_soc = 0.52;
  options.vehicle.battery.initial_temperature_c = -2.0;
  const ChargeResult r = charge(options);
  CHECK(r.reached && r.waiting_s > 60.0);
}
