// SPDX-License-Identifier: Apache-2.0
// Drawn configurations: what a car file can say, what the firmware accepts, and what a refusal says.
#include "apps/firmware_keys.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <fmt/format.h>

#include "apps/firmware_config.hpp"
#include "core/parameter_file.hpp"
#include "core/parameter_table.hpp"
#include "plant_sim/core/scratch.hpp"
#include "race/limit_costs.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

const DataFolder kData(VOLTLAP_SOURCE_DIR "/plant_sim/data");

void assign(VehicleParameters& car, std::string_view key, double value) {
  std::visit(
      [&](auto access) {
        using Value = std::remove_cvref_t<decltype(access(car))>;
        if constexpr (std::is_same_v<Value, int>) access(car) = static_cast<int>(value);
        if constexpr (std::is_same_v<Value, double> || std::is_same_v<Value, std::optional<double>>)
          access(car) = value;
      },
      find_parameter(key)->access);
}

template <class Config>
std::vector<std::int32_t> numbers(std::span<const FirmwareKey<Config>> keys, const Config& config) {
  std::vector<std::int32_t> out;
  for (const auto& key : keys) out.push_back(key.get(config));
  return out;
}

std::vector<std::int32_t> all_of(const bms::Config& c) {
  std::vector<std::int32_t> out = numbers(bms_keys(), c);
  out.insert(out.end(), {static_cast<int>(c.soc_method), static_cast<int>(c.limit_method), c.limit_horizon.ms(),
                        c.capacity_mah, c.heat_capacity_j_per_k, c.ocv.count});
  for (int i = 0; i < c.ocv.count; ++i) out.insert(out.end(), {c.ocv.soc[i].raw(), c.ocv.voltage[i].raw()});
  for (int i = 0; i < c.resistance.count; ++i) out.push_back(c.resistance.resistance[i].raw());
  out.push_back(c.resistance.ppm_per_kelvin);
  return out;
}

std::vector<std::int32_t> all_of(const master::Config& c) {
  std::vector<std::int32_t> out = numbers(master_keys(), c);
  out.push_back(static_cast<int>(c.arbitration));
  return out;
}

/// What the car says to this node, not checked; tables and capacity are those of `base`.
template <class Config>
Config unchecked(const VehicleParameters& car, const Config& base) {
  Config out = base;
  fill_from_keys(car, out);
  return out;
}

bms::Config checked(const VehicleParameters& car, const bms::Config&) { return bms_config(car); }
master::Config checked(const VehicleParameters& car, const master::Config&) { return master_config(car); }

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  int whole(int high) { return std::uniform_int_distribution<int>(0, high)(random_); }

  /// Anything in the row's range, near what the car has, or another key's value: limits touch there.
  double value(const ParameterRow& row, const VehicleParameters& car, const ParameterRow& another) {
    const double now = number_value(row, car);
    switch (whole(3)) {
      case 0: return std::uniform_real_distribution<double>(row.low, row.high)(random_);
      case 1: return std::clamp(number_value(another, car), row.low, row.high);
      case 2: return whole(1) == 0 ? row.low : row.high;
      default: return std::clamp(now * std::uniform_real_distribution<double>(0.9, 1.1)(random_), row.low, row.high);
    }
  }

 private:
  std::mt19937_64 random_;
};

/// The value on the right side of the bound; that of the other key when the key's own range does not reach there.
void mend(VehicleParameters& car, const Refusal& refusal) {
  const bool up = refusal.order == Order::kAbove || refusal.order == Order::kAtLeast;
  const bool strict = refusal.order == Order::kAbove || refusal.order == Order::kBelow;
  const double step = strict ? (up ? refusal.step : -refusal.step) : 0.0;
  const ParameterRow& row = *find_parameter(refusal.key);
  const double wanted = refusal.bound + step;
  if (wanted >= row.low && wanted <= row.high) {
    assign(car, refusal.key, wanted);
  } else {
    assign(car, refusal.other, number_value(row, car) - step);
  }
}

template <class Config>
void accepted_as_the_firmware_does(std::span<const FirmwareKey<Config>> keys, const Config& base) {
  const VehicleParameters given = load_vehicle(kData, "vtm16e").parameters;
  std::set<std::string> seen;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    const std::string trial = fmt::format("seed {}", seed);
    Draw draw(seed);
    VehicleParameters car = given;
    for (int k = draw.whole(4); k >= 0; --k) {
      const auto any = [&]() -> const ParameterRow& {
        return *find_parameter(keys[static_cast<std::size_t>(draw.whole(static_cast<int>(keys.size()) - 1))].key);
      };
      const ParameterRow& row = any();
      assign(car, row.key, draw.value(row, car, any()));
    }
    const Config config = unchecked(car, base);
    const std::string said = complaint([&] { (void)checked(car, base); });
    const auto refused = refusal(car, config);
    CHECK_EQUAL_TEXT(config_check(config) == decltype(config_check(config)){}, said == "no error", trial.c_str());
    CHECK_EQUAL_TEXT(refused.has_value(), said != "no error", trial.c_str());
    if (!refused) continue;
    seen.insert(refused->sentence.substr(0, refused->sentence.find(' ')));
    STRCMP_CONTAINS_TEXT(std::string(refused->key).c_str(), said.c_str(), trial.c_str());
    STRCMP_CONTAINS_TEXT(std::string(refused->other).c_str(), said.c_str(), trial.c_str());
    const auto before = config_check(config);
    mend(car, *refused);
    CHECK_TEXT(config_check(unchecked(car, base)) != before, fmt::format("{}: {}", trial, said).c_str());
  }
  CHECK(seen.size() > keys.size() / 3);
}

/// A value in the row's range that the firmware counts differently.
double other_value(const ParameterRow& row, const VehicleParameters& car) {
  const double now = number_value(row, car);
  return now < 0.5 * (row.low + row.high) ? row.high : row.low;
}

template <class Config>
void every_key_is_its_field(std::span<const FirmwareKey<Config>> keys, const Config& base) {
  const VehicleParameters given = load_vehicle(kData, "vtm16e").parameters;
  const auto before = numbers(keys, unchecked(given, base));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    VehicleParameters car = given;
    const ParameterRow& row = *find_parameter(keys[i].key);
    assign(car, row.key, other_value(row, car));
    const auto after = numbers(keys, unchecked(car, base));
    CHECK_TRUE_TEXT(after[i] != before[i], row.key.data());
    LONGS_EQUAL_TEXT(std::lround(other_value(row, given) * keys[i].counts_per_unit), after[i], row.key.data());
    for (std::size_t k = 0; k < keys.size(); ++k) {
      // Only a value that follows this one may move with it.
      const bool follows = find_parameter(keys[k].key)->followed.words.find(row.key) != std::string_view::npos ||
                           find_parameter(keys[k].key)->followed.value != nullptr;
      if (k != i && !follows) LONGS_EQUAL_TEXT(before[k], after[k], row.key.data());
    }
  }
}

}  // namespace

TEST_GROUP(FirmwareKeys) {
  const VehicleParameters car = load_vehicle(kData, "vtm16e").parameters;
  const bms::Config bms = bms_config(car);
  const master::Config master = master_config(car);

  template <class Change>
  void changes_the_bms(const Change& change) {
    VehicleParameters changed = car;
    change(changed.bms);
    CHECK(all_of(bms_config(changed)) != all_of(bms));
  }
};

TEST(FirmwareKeys, BmsAcceptsWhatItsCheckAcceptsAndARefusalNamesWhatMendsIt) {
  accepted_as_the_firmware_does(bms_keys(), bms);
}

TEST(FirmwareKeys, MasterAcceptsWhatItsCheckAcceptsAndARefusalNamesWhatMendsIt) {
  accepted_as_the_firmware_does(master_keys(), master);
}

TEST(FirmwareKeys, EveryKeyIsItsFieldAndNoOther) {
  every_key_is_its_field(bms_keys(), bms);
  every_key_is_its_field(master_keys(), master);
}

TEST(FirmwareKeys, WithoutKeysTheMasterHasTheFirmwaresOwnDefaults) {
  CHECK(all_of(master) == all_of(master::Config{}));
}

TEST(FirmwareKeys, WithoutKeysTheBmsHasTheFirmwaresOwnDefaultsBesideThePack) {
  const std::set<std::string_view> of_the_pack = {
      "battery.cells_in_series", "sensors.temperature_count", "bms.discharge_current_max_a",
      "bms.charge_current_max_a", "bms.discharge_current_trip_a", "bms.charge_current_trip_a",
      "bms.charger_current_max_a", "bms.charge_current_end_a"};
  const bms::Config own;
  for (const auto& key : bms_keys()) {
    if (!of_the_pack.contains(key.key)) LONGS_EQUAL_TEXT(key.get(own), key.get(bms), key.key.data());
  }
}

TEST(FirmwareKeys, EveryRowOfTheFirmwareReachesIt) {
  std::set<std::string_view> reached = {"bms.resistance_ohm", "bms.resistance_per_kelvin", "bms.capacity_ah",
                                        "bms.ocv_soc", "bms.ocv_v", "bms.soc_method", "bms.limit_method",
                                        "bms.limit_horizon_s", "master.arbitration"};
  for (const auto& key : bms_keys()) reached.insert(key.key);
  for (const auto& key : master_keys()) reached.insert(key.key);
  for (const ParameterRow& row : parameter_rows()) {
    if (row.key.starts_with("bms.") || row.key.starts_with("master.")) {
      CHECK_TRUE_TEXT(reached.contains(row.key), row.key.data());
    }
  }
}

TEST(FirmwareKeys, WordsTablesAndBeliefsChangeTheConfigurationToo) {
  changes_the_bms([](BmsSection& own) { own.soc_method = "none"; });
  changes_the_bms([](BmsSection& own) { own.limit_method = "table"; });
  changes_the_bms([](BmsSection& own) { own.limit_horizon_s = 10.0; });
  changes_the_bms([](BmsSection& own) { own.capacity_ah = 40.0; });
  changes_the_bms([](BmsSection& own) { own.resistance_ohm = 0.003; });
  changes_the_bms([](BmsSection& own) { own.ocv_soc = {0.0, 1.0}, own.ocv_v = {3.0, 4.2}; });
  VehicleParameters changed = car;
  changed.bms.resistance_ohm = 0.003;
  changed.bms.resistance_per_kelvin = -0.01;
  LONGS_EQUAL(-10'000, bms_config(changed).resistance.ppm_per_kelvin);
  changed.master.arbitration = "literal";
  CHECK(master_config(changed).arbitration == master::Arbitration::kLiteral);
}

TEST(FirmwareKeys, ValuesAsListedGiveTheSameConfiguration) {
  std::vector<std::string> settings;
  for (const auto& [key, value] : parameter_values(car)) {
    if (key.starts_with("bms.") || key.starts_with("master.")) settings.push_back(key + "=" + value);
  }
  const VehicleParameters again = load_vehicle(kData, "vtm16e", settings).parameters;
  CHECK(all_of(bms_config(again)) == all_of(bms));
  CHECK(all_of(master_config(again)) == all_of(master));
}

TEST(FirmwareKeys, RefusalSaysWhereTheValueStandsAndWhatItFollows) {
  const auto complaint_of = [](const std::vector<std::string>& settings) {
    const LoadedVehicle loaded = load_vehicle(kData, "vtm16e", settings);
    return complaint([&] {
      (void)bms_config(loaded.parameters, loaded.origin);
      (void)master_config(loaded.parameters, loaded.origin);
    });
  };
  STRCMP_EQUAL("--set bms.temperature_derating_start_c: found bms.temperature_derating_start_c = 60 degC, which is not "
               "below bms.temperature_max_c = 60 degC; expected what the BMS accepts. Change one of the two.",
               complaint_of({"bms.temperature_derating_start_c=60"}).c_str());
  STRCMP_CONTAINS("60 degC (59.96 to the firmware's nearest 0.1 degC), which is not below",
                  complaint_of({"bms.temperature_derating_start_c=59.96"}).c_str());
  STRCMP_CONTAINS("--set inverter.current_max_a: found master.phase_current_max_a = 551 A "
                  "(from inverter.current_max_a), which is not at most 550 A",
                  complaint_of({"inverter.current_max_a=551"}).c_str());
  STRCMP_CONTAINS("--set master.power_max_kw: found master.power_max_kw = 80.1 kW, which is not at most 80 kW",
                  complaint_of({"master.power_max_kw=80.1"}).c_str());
}

TEST(FirmwareKeys, LiftedLimitsAreAcceptedAloneAndTogether) {
  std::vector<std::string> all;
  for (std::size_t reason = 1; reason < kLimitReasons; ++reason) {
    const std::vector<std::string> lifted = settings_of(lifted_keys(reason, car));
    all.insert(all.end(), lifted.begin(), lifted.end());
    for (const auto& settings : {lifted, all}) {
      const VehicleParameters without = load_vehicle(kData, "vtm16e", settings).parameters;
      (void)bms_config(without);
      (void)master_config(without);
      CHECK_TRUE_TEXT(lifted_keys(reason, without).empty(), limit_reason_name(reason));
    }
  }
}

TEST(FirmwareKeys, ListsOfPointsThatDoNotFitAreRefused) {
  const auto refused = [this](std::vector<double> soc, std::vector<double> volts) {
    VehicleParameters changed = car;
    changed.bms.ocv_soc = std::move(soc);
    changed.bms.ocv_v = std::move(volts);
    return complaint([&] { (void)bms_config(changed); });
  };
  STRCMP_CONTAINS("bms.ocv_v", refused({0.0, 1.0}, {3.0}).c_str());
  STRCMP_CONTAINS("do not rise", refused({0.0, 1.0}, {3.0, 3.0}).c_str());
  STRCMP_CONTAINS("bms.ocv_soc", refused({0.5, 0.5}, {3.0, 3.5}).c_str());
}
