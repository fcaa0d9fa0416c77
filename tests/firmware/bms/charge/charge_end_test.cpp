// SPDX-License-Identifier: Apache-2.0
// Where a charge ends: full, even, and never above a cell's greatest voltage.
#include "bms/charge/charge.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

namespace {

constexpr std::int32_t kHour = 3'600'000;

double spread(const std::vector<ChargeBench::Cell>& cells) {
  const auto by_soc = [](const auto& a, const auto& b) { return a.soc < b.soc; };
  const auto [low, high] = std::minmax_element(cells.begin(), cells.end(), by_soc);
  return high->soc - low->soc;
}

}  // namespace

TEST_GROUP(ChargeEnd){};

// BMS-052
TEST(ChargeEnd, UnevenCellsBecomeFullAndEvenAndNoneIsAboveItsGreatestVoltage) {
  ChargeBench charger(charge_config(), 0.8);
  for (std::size_t i = 0; i < 24; ++i) {
    charger.cells[i].soc += 0.0005 * static_cast<double>(i % 7);
    charger.cells[i].capacity = 1.0 - 0.002 * static_cast<double>(i % 5);
    charger.cells[i].resistance = 0.8 + 0.02 * static_cast<double>(i % 11);
  }
  charger.charge();
  const std::int32_t took = charger.until_phase(ChargePhase::kFull, 12 * kHour);
  CHECK(took >= 0);
  std::printf("BMS-052: %.4f V at most\n", charger.highest_v);
  CHECK_TEXT(charger.highest_v < 4.2, "a cell is above its greatest voltage");
  CHECK(1.2 * spread(charger.cells) < 0.0035);
  for (const auto& cell : charger.cells) CHECK(cell.soc > 0.985);
  charger.run(500);
  CHECK(all_open(charger.bench.out) && charger.bench.out.state == can::BmsState::kOpen);
  CHECK(charger.bench.out.waits_for == can::WaitsFor::kChargeSwitchOff);
  CHECK_EQUAL(0, charger.bench.out.faults);
}

TEST(ChargeEnd, ASmallChargerIsNotTakenForAFullCell) {
  ChargeBench charger(charge_config(), 0.95);
  charger.gives_at_most_a = 0.4;  // less than the current at which a cell counts as full
  charger.charge();
  const std::int32_t took = charger.until_phase(ChargePhase::kFull, 4 * kHour);
  CHECK(took > kHour);
  for (const auto& cell : charger.cells) CHECK(cell.soc > 0.985);
  CHECK(charger.highest_v < 4.2);
}

TEST(ChargeEnd, AWoundUpHoldDoesNotOvershoot) {
  ChargeBench charger(charge_config(), 0.97);
  charger.gives_at_most_a = 5.0;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kFull, kHour) >= 0);
  CHECK(charger.highest_v < 4.198);
}

TEST(ChargeEnd, AFlatCurveIsFullAtItsEndNotOnItsPlateau) {
  Config config = charge_config();
  config.ocv.count = 4;
  const std::int32_t soc[] = {0, 100'000, 950'000, 1'000'000}, volts[] = {28'000, 32'800, 33'300, 34'500};
  for (int i = 0; i < 4; ++i) {
    config.ocv.soc[i] = Soc::from_raw(soc[i]);
    config.ocv.voltage[i] = CellVoltage::from_raw(volts[i]);
  }
  config.cell_voltage_max = CellVoltage::from_raw(36'500);
  config.cell_voltage_trip_high = CellVoltage::from_raw(37'000);
  config.balancing_voltage_min = CellVoltage::from_raw(33'000);
  ChargeBench charger(config, 0.9);
  charger.ocv = [](double s) { return s < 0.95 ? 3.28 + 0.05 / 0.85 * (s - 0.1) : 3.33 + 0.12 / 0.05 * (s - 0.95); };
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kFull, 2 * kHour) >= 0);
  for (const auto& cell : charger.cells) CHECK(cell.soc > 0.995 && cell.soc < 1.005);
}

TEST(ChargeEnd, APackThatIsFullIsNotChargedFurther) {
  ChargeBench charger(charge_config(), 0.9965);  // 4.1958 V, above where a charge ends
  charger.run(3'000);
  charger.bench.io.charge_switch = true;
  CHECK(charger.until_phase(ChargePhase::kFull, 100'000) >= 0);
  DOUBLES_EQUAL(0.9965, charger.cells[0].soc, 1e-6);
}

TEST(ChargeEnd, BalancingThatTakesTooLongIsGivenUpByName) {
  Config config = charge_config();
  config.balancing_time_max = Duration::from_ms(300'000);
  ChargeBench charger(config, 0.97);
  charger.cells[4].soc = 0.98;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kStopped, 2 * kHour) >= 0);
  CHECK(charger.reason() == ChargeReason::kBalancingTime);
  CHECK(charger.bench.state.cells_bled == 0);
}

TEST(ChargeEnd, CellsThatMayNotBeBledAreNamed) {
  Config config = charge_config();
  config.balancing_voltage_min = CellVoltage::from_raw(42'500);
  ChargeBench charger(config, 0.97);
  charger.cells[4].soc = 0.98;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kStopped, 2 * kHour) >= 0);
  CHECK(charger.reason() == ChargeReason::kNotBalanced);
}

TEST(ChargeEnd, AChargeOfWeakCellsAccusesNoChannel) {
  ChargeBench charger(charge_config(), 0.1);
  charger.cells[3].capacity = 0.88;
  charger.cells[9].resistance = 1.8;
  charger.charge();
  CHECK(charger.until_phase(ChargePhase::kResting, 2 * kHour) >= 0);
  CHECK_EQUAL(0, charger.bench.out.faults);
  CHECK(charger.highest_v < 4.2);
}

// BMS-061
TEST(ChargeEnd, AnAgedCellThatRisesMoreThanTheOthersAccusesNoChannel) {
  ChargeBench charger(charge_config(), 0.3);
  charger.cells[9].resistance = 3.5;  // 0.1 V above the others at 20 A
  charger.charge();
  charger.run(600'000);
  CHECK(charger.phase() == ChargePhase::kCharging);
  CHECK_EQUAL(0, charger.bench.out.faults);
}

// BMS-061
TEST(ChargeEnd, AChannelThatDriftsUpwardsIsFoundInACharge) {
  ChargeBench charger(charge_config(), 0.3);
  charger.charge();
  charger.run(60'000);
  std::int32_t took = 0;
  for (; !has(charger.bench.out, can::BmsFault::kCellImplausible) && took < 120'000; took += 10) {
    charger.cells[9].drift_v += 1e-4;  // 10 mV/s
    charger.tick();
  }
  std::printf("BMS-061 in a charge: %.2f V above the others\n", charger.cells[9].drift_v);
  CHECK(charger.cells[9].drift_v < 0.45);
  CHECK(charger.bench.out.suspect == 9 && charger.phase() == ChargePhase::kStopped);
}
