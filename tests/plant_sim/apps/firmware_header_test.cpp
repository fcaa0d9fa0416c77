// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_header.hpp"

#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "apps/firmware_config.hpp"
#include "apps/master_header.hpp"
#include "core/parameter_file.hpp"
#include "pack_config.hpp"
#include "plant_sim/core/scratch.hpp"
#include "race/endurance.hpp"

#include <fmt/format.h>

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

const DataFolder kData(VOLTLAP_SOURCE_DIR "/plant_sim/data");

/// With the filter: its circuit is in the header, too.
VehicleParameters car_of_the_header() {
  return load_vehicle(kData, "vtm16e", {"bms.soc_method=ekf"}).parameters;
}

/// The car's BMS, and beside it one with the header, on the same frames.
class Twin final : public Ecus {
 public:
  explicit Twin(const VehicleParameters& car)
      : host_(bms_config(car)), header_(bms::kPackConfig), master_(master_config(car)) {}

  void bms(Instant now, FrameView rx, TxQueue& tx) override {
    const std::size_t before = tx.size();
    host_.tick(now, rx, tx);
    other_.clear();
    header_.tick(now, rx, other_);
    LONGS_EQUAL(tx.size() - before, other_.size());
    for (std::size_t i = 0; i < other_.size(); ++i) {
      const Frame &a = tx[before + i], &b = other_[i];
      CHECK(a.id == b.id && a.dlc == b.dlc);
      MEMCMP_EQUAL(a.data, b.data, a.dlc);
    }
    LONGS_EQUAL(host_.state().soc.value.raw(), header_.state().soc.value.raw());
    CHECK(host_.state().soc.charge == header_.state().soc.charge);
    ++ticks;
    valid_ticks += header_.state().soc.valid ? 1 : 0;
    soc_ppm = header_.state().soc.value.raw();
  }
  void master(Instant now, FrameView rx, TxQueue& tx) override { master_.tick(now, rx, tx); }

  long ticks = 0, valid_ticks = 0, soc_ppm = 0;

 private:
  app::BmsNode host_, header_;
  app::MasterNode master_;
  TxQueue other_;
};

struct Quiet : EnduranceObserver {
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample&) override {}
  void on_progress(double, double) override {}
  bool stop_requested() override { return false; }
};

}  // namespace

TEST_GROUP(FirmwareHeader) {
  VehicleParameters car = car_of_the_header();
  std::string complaint_of_tables() {
    return complaint([&] { (void)table_rounding(car, bms_config(car)); });
  }
};

TEST(FirmwareHeader, TablesAreThoseOfTheHost) {
  const bms::Config host = bms_config(car);
  const bms::Config& header = bms::kPackConfig;
  LONGS_EQUAL(host.ocv.count, header.ocv.count);
  LONGS_EQUAL(host.resistance.count, header.resistance.count);
  for (std::size_t i = 0; i < bms::kMaxTablePoints; ++i) {
    LONGS_EQUAL(host.ocv.soc[i].raw(), header.ocv.soc[i].raw());
    LONGS_EQUAL(host.ocv.voltage[i].raw(), header.ocv.voltage[i].raw());
    LONGS_EQUAL(host.resistance.soc[i].raw(), header.resistance.soc[i].raw());
    LONGS_EQUAL(host.resistance.resistance[i].raw(), header.resistance.resistance[i].raw());
  }
  LONGS_EQUAL(host.resistance.ppm_per_kelvin, header.resistance.ppm_per_kelvin);
  LONGS_EQUAL(host.resistance.reference.raw(), header.resistance.reference.raw());
  LONGS_EQUAL(host.capacity_mah, header.capacity_mah);
  LONGS_EQUAL(host.cells_in_series, header.cells_in_series);
  CHECK(bms::SocMethod::kEkf == header.soc_method);
  MEMCMP_EQUAL(&host.branches, &header.branches, sizeof(host.branches));
}

// A field that is new in the configuration is a line of firmware_header.cpp too.
TEST(FirmwareHeader, EveryFieldOfTheConfigurationIsInIt) {
  bms::Config changed = bms_config(car);
  auto* bytes = reinterpret_cast<unsigned char*>(&changed);
  const std::string before = firmware_header(car, changed, {}, {}, {});
  std::size_t silent = 0;
  for (std::size_t i = 0; i < sizeof(bms::Config); ++i) {
    bytes[i] ^= 1U;
    silent += firmware_header(car, changed, {}, {}, {}) == before ? 1U : 0U;
    bytes[i] ^= 1U;
  }
  // Silent are the unused points of the tables and what the compiler leaves between fields.
  const std::size_t points = 2 * bms::kMaxTablePoints - changed.ocv.count - changed.resistance.count;
  const std::size_t branch_points = bms::kMaxTablePoints - changed.resistance.count;
  const std::size_t warmth_points = bms::kMaxWarmthPoints - changed.branches.warmth_count;
  const std::size_t unused = (points * 2 + branch_points * 5 + warmth_points * 6) * sizeof(std::int32_t);
  CHECK(silent >= unused);
  CHECK(silent <= unused + 21);
}

// The same of master_header.cpp.
TEST(FirmwareHeader, EveryFieldOfTheMastersConfigurationIsInItsHeader) {
  master::Config changed = master_config(car);
  changed.inverter_protocol = InverterProtocol::kAmk;  // the others say nothing of motors at the wheels
  auto* bytes = reinterpret_cast<unsigned char*>(&changed);
  const std::string before = master_header(car.name, changed, {});
  std::size_t silent = 0;
  for (std::size_t i = 0; i < sizeof(master::Config); ++i) {
    bytes[i] ^= 1U;
    silent += master_header(car.name, changed, {}) == before ? 1U : 0U;
    bytes[i] ^= 1U;
  }
  CHECK(silent <= 6);  // what the compiler leaves behind the bytes of Arbitration and of InverterProtocol
}

TEST(FirmwareHeader, BmsWithTheHeaderCountsAndSendsTheSameBitForBit) {
  EnduranceOptions options;
  options.vehicle = car;
  options.track = load_track(kData.find("tracks", "michigan_2015", "test"));
  options.laps = 1;
  options.representative_cell = true;
  Twin twin(car);
  Quiet quiet;
  CHECK(run_endurance(options, twin, quiet).finished);
  CHECK(twin.ticks > 7000);
  CHECK(twin.valid_ticks > twin.ticks - 100);
  CHECK(twin.soc_ppm < 990'000);
}

TEST(FirmwareHeader, SameConfigurationSameBytes) {
  const bms::Config config = bms_config(car);
  const TableRounding rounding = table_rounding(car, config);
  const std::string text = firmware_header(car, config, rounding, {}, {"1.0", "command"});
  STRCMP_EQUAL(text.c_str(), firmware_header(car, config, rounding, {}, {"1.0", "command"}).c_str());
  STRCMP_CONTAINS("static_assert(config_check(kPackConfig)", text.c_str());
  STRCMP_CONTAINS("mV from the cell's curve", text.c_str());
}

TEST(FirmwareHeader, RoundingOfAStraightCurveIsThatOfItsSteps) {
  // 3 V + 1.00008 V s: points at 5 % fall between steps of 0.1 mV; straight between the points by nature.
  car.cell.ocv_polynomial_v = {3.0, 1.00008};
  const TableRounding rounding = table_rounding(car, bms_config(car));
  CHECK(rounding.ocv_points_v > 1e-5 && rounding.ocv_points_v <= 0.5001e-4);
  CHECK(rounding.ocv_between_v <= 1.01e-4);  // two roundings meet
  DOUBLES_EQUAL(0.001, rounding.soc_per_mv, 2e-6);
  LONGS_EQUAL(0, rounding.ocv_raised_points);
}

TEST(FirmwareHeader, CurveBetweenThePointsIsAsFarAsItsBend) {
  // 3 V + s^2, halved again and again: 31 stretches are 1/32 long but one of 1/16, and a chord lies h^2/4 above its
  // middle.
  car.cell.ocv_polynomial_v = {3.0, 0.3, 1.0};
  DOUBLES_EQUAL(1.0 / 1024.0, table_rounding(car, bms_config(car)).ocv_between_v, 0.11e-3);
}

TEST(FirmwareHeader, PointsStandWhereTheCurveBends) {
  // A knee as measured cells have it: 0.9 V within the first tenth.
  car.cell.ocv_polynomial_v.clear();
  car.cell.ocv_soc = {0.0, 0.01, 0.02, 0.04, 0.07, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0};
  car.cell.ocv_v = {2.70, 3.05, 3.25, 3.40, 3.52, 3.60, 3.70, 3.78, 3.90, 4.08, 4.18};
  const bms::Config config = bms_config(car);
  LONGS_EQUAL(11, config.ocv.count);  // straight between its own points: no more are needed
  CHECK(table_rounding(car, config).ocv_between_v <= 1.01e-4);
}

TEST(FirmwareHeader, PlateauIsRaisedAndSaid) {
  car.cell.ocv_polynomial_v.clear();
  car.cell.ocv_soc = {0.0, 0.4, 0.6, 1.0};
  car.cell.ocv_v = {3.0, 3.3, 3.3, 3.6};
  STRCMP_CONTAINS("so flat at SOC", complaint_of_tables().c_str());
  car.cell.ocv_v = {3.0, 3.3, 3.302, 3.6};
  CHECK(table_rounding(car, bms_config(car)).soc_per_mv > 0.09);
}

TEST(FirmwareHeader, ResistanceTooSmallForMicroohmsIsRefused) {
  for (auto* map : {&car.cell.r0_ohm, &car.cell.branches[0].r_ohm, &car.cell.branches[1].r_ohm}) {
    map->value.assign(car.cell.soc_breakpoints.size(), 1.1e-6);
    map->per_kelvin = map->per_ampere = 0.0;
  }
  STRCMP_CONTAINS("counts in microohms", complaint_of_tables().c_str());
}

TEST(FirmwareHeader, TheBranchesForAFilterAreTheCellsOwnTwoAsIntegersOfAGroup) {
  car.battery.cells_in_parallel = 2;
  const bms::Config config = bms_config(car);
  const BranchReduction reduction = two_branch_tables(car, config);
  LONGS_EQUAL(config.resistance.count, reduction.circuits.size());
  STRCMP_CONTAINS("the cell file's two", branches_text(car, reduction).c_str());
  const std::string text = firmware_header(car, config, {}, reduction, {"1.0", "command"});
  const CircuitParameters full = CellTables(car.cell).circuit(1.0, 30.0, car.cell.reference_current_a);
  const auto last_of = [&](const std::string& name) {
    const std::size_t begin = text.find(name + "[]"), end = text.find("\n};", begin);
    return std::stod(text.substr(text.rfind(' ', end) + 1));
  };
  DOUBLES_EQUAL(0.5e6 * full.r0_ohm, last_of("kSeriesResistance"), 0.5);
  DOUBLES_EQUAL(0.5e6 * full.r_ohm[1], last_of("kBranch2Resistance"), 0.5);
  DOUBLES_EQUAL(1e3 * full.tau_s[0], last_of("kBranch1Time"), 0.5);
  DOUBLES_EQUAL(1e3 * full.tau_s[1], last_of("kBranch2Time"), 0.5);
}

TEST(FirmwareHeader, WhatTwoBranchesCostInThePlaceOfThreeIsSaid) {
  car.cell.branches[2] = car.cell.branches[1];
  for (double& tau : car.cell.branches[2].tau_s.value) tau *= 0.01;
  const bms::Config config = bms_config(car);
  const BranchReduction reduction = two_branch_tables(car, config);
  CHECK(reduction.largest_v > 1e-4 && reduction.rms_v < reduction.largest_v);
  const std::string said = branches_text(car, reduction);
  STRCMP_CONTAINS("2 in the place of 3. After a step of 1C, 55.2 A, their voltage is off by at most ", said.c_str());
  STRCMP_CONTAINS(fmt::format("{:.2f} mV, at SOC", 1e3 * reduction.largest_v).c_str(), said.c_str());
  STRCMP_CONTAINS(said.substr(0, 40).c_str(), firmware_header(car, config, {}, reduction, {"1.0", "c"}).c_str());
  car.cell.branches[1] = car.cell.branches[2] = {};
  STRCMP_CONTAINS("the second is 0 ohm", branches_text(car, two_branch_tables(car, config)).c_str());
}

TEST(FirmwareHeader, TheBmsBelievesTheResistanceOfAllBranches) {
  const auto middle = [this] { return bms_config(car).resistance.resistance[10].raw(); };
  const auto before = middle();
  car.cell.branches[2] = car.cell.branches[3] = car.cell.branches[0];
  const double added = 2.0 * car.cell.branches[0].r_ohm.value[8];
  LONGS_EQUAL(before + std::lround(1e6 * added), middle());
}
