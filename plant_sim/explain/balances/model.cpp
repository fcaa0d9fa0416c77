// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "core/signal.hpp"
#include "core/toml_text.hpp"

namespace voltlap::plant {
namespace {

void set_cell_model(const std::vector<std::string>& settings, VehicleParameters& car) {
  car.battery.cells_in_series = 0;
  car.battery.cells_in_parallel = 1;
  car.battery.initial_soc = 1.0;
  car.environment.ambient_c = car.battery.initial_temperature_c = car.cell.reference_temperature_c;
  for (const std::string& text : settings) {
    const Setting setting = parse_setting(text);
    const auto number = number_of(*setting.value);
    if (setting.key == "battery.cells_in_series" && number && *number >= 1) {
      car.battery.cells_in_series = static_cast<int>(*number);
    } else if (setting.key == "battery.cells_in_parallel" && number && *number >= 1) {
      car.battery.cells_in_parallel = static_cast<int>(*number);
    } else if (setting.key == "environment.ambient_c" && number) {
      car.environment.ambient_c = car.battery.initial_temperature_c = *number;
    } else {
      throw InputError("--set " + text, "a setting that a cell file does not take",
                       "battery.cells_in_series, battery.cells_in_parallel or environment.ambient_c with a number",
                       "Correct it, or give a pack or vehicle file as --model");
    }
  }
}

bool states(const std::vector<std::string>& settings, const std::string& key) {
  return std::any_of(settings.begin(), settings.end(),
                     [&](const std::string& text) { return parse_setting(text).key == key; });
}

/// What "25.3" says is known to its last digit, 0.1; 0 where a key is not set.
double last_digit_of(const std::vector<std::string>& settings, const std::string& key) {
  double out = 0.0;
  for (const std::string& text : settings) {
    if (parse_setting(text).key != key) continue;
    const std::size_t point = text.find('.', text.find('='));
    const std::size_t end = point == std::string::npos ? point : text.find_first_not_of("0123456789", point + 1);
    const std::size_t digits = point == std::string::npos ? 0 : std::min(end, text.size()) - point - 1;
    out = std::pow(10.0, -static_cast<double>(digits));
  }
  return out;
}

}  // namespace

Model load_model(const DataFolder& data, const std::string& name, const std::vector<std::string>& settings) {
  const ModelFile file = find_model_file(data, name, "--model");
  Model out;
  out.path = file.path;
  out.air_step_k = last_digit_of(settings, "environment.ambient_c");
  out.kind = file.kind;
  if (out.kind == ModelKind::kCell) {
    out.world.car.cell = load_cell(data, out.path, "--model");
    set_cell_model(settings, out.world.car);
    return out;
  }
  out.temperature_stated = states(settings, "battery.initial_temperature_c");
  if (out.kind == ModelKind::kVehicle) {
    out.world.car = load_vehicle(data, out.path, settings).parameters;
    if (out.world.car.powertrain.motors != 1) {
      throw InputError("--model " + name, fmt::format("a car with {} motors", out.world.car.powertrain.motors),
                       "a car with one motor on the rear axle, a pack or a cell: logs are explained by one motor's "
                       "speed and current",
                       "Give the car's cell file or a pack file to explain its battery");
    }
    out.world.pack_resistance_ohm = out.world.car.battery.contact_resistance_ohm;
    return out;
  }
  std::vector<std::string> all = pack_settings(out.path);
  all.insert(all.end(), settings.begin(), settings.end());
  out.world.car = load_vehicle(data, kPackBase, all).parameters;
  out.world.pack_resistance_ohm = out.world.car.battery.contact_resistance_ohm;
  out.world.car.tyres.radius_m = 0.0;  // a pack has no wheels: no balance of the car
  return out;
}

namespace {

/// Pack voltage in cells of the log: median over its rows of pack over mean cell; 0 without both.
double cells_in_pack_voltage(const Recording& log, const std::vector<std::string>& cells) {
  const Eigen::VectorXd* pack = log.find("pack_voltage");
  if (pack == nullptr || cells.empty()) return 0.0;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(log.rows()), count = sum;
  for (const std::string& role : cells) {
    const Eigen::ArrayXd v = log.find(role)->array();
    sum += v.isFinite().select(v, 0.0);
    count += v.isFinite().cast<double>();
  }
  std::vector<double> ratio;
  for (Eigen::Index row = 0; row < log.rows(); ++row) {
    if (count(row) > 0.5 * static_cast<double>(cells.size()) && sum(row) > 0.0 && std::isfinite((*pack)(row)))
      ratio.push_back((*pack)(row)*count(row) / sum(row));
  }
  return ratio.empty() ? 0.0 : median(std::move(ratio));
}

/// A pack voltage that is of another number of cells than the model's would be told as an error of the sensor's gain.
void check_count(int series, const Recording& log) {
  constexpr double kNoGain = 0.15;             // no sensor is so wrong
  constexpr double kGain = 0.02, kOfIt = 0.3;  // one may be; nearer to the log's own number by far
  const std::vector<std::string> cells = log.numbered("cell_voltage_");
  const double count = static_cast<double>(cells.size()), found = cells_in_pack_voltage(log, cells);
  if (found == 0.0 || cells.size() < 2) return;
  const double off = std::abs(found / series - 1.0);
  if (off > kNoGain || (count != series && off > kGain && std::abs(found / count - 1.0) < kOfIt * off)) {
    throw InputError(log.path, fmt::format("a pack voltage of {:.4g} times its mean cell, and {} cells", found, count),
                     fmt::format("the model's {} cells", series),
                     "Correct battery.cells_in_series of the model, or the unit or the column of pack_voltage in the "
                     "map");
  }
}

}  // namespace

void fit_to_log(Model& model, const Recording& log) {
  int& series = model.world.car.battery.cells_in_series;
  const auto cells = static_cast<int>(log.numbered("cell_voltage_").size());
  if (log.find("voltage") != nullptr) {
    series = 1;
  } else if (cells > 0 && model.kind == ModelKind::kCell && series == 0) {
    series = cells;
  }
  if (series == 0) {
    throw InputError(log.path, "a pack's voltage and a cell file as model", "the number of cells in series",
                     "Add --set battery.cells_in_series=N (and battery.cells_in_parallel=M)");
  }
  if (cells > 1 && cells > series) {
    throw InputError(log.path, fmt::format("{} cell voltages", cells),
                     fmt::format("at most the model's {} cells", series),
                     "Correct battery.cells_in_series of the model");
  }
  const CellParameters& cell = model.world.car.cell;
  for (const auto& [role, count] : {std::pair{"voltage", 1}, {"pack_voltage", series}, {"cell_voltage_1", 1}}) {
    const Eigen::VectorXd* volts = log.find(role);
    if (volts == nullptr) continue;
    std::vector<double> sample;
    for (const double v : *volts) {
      if (std::isfinite(v)) sample.push_back(v / count);
    }
    if (sample.empty()) continue;
    const double middle = median(std::move(sample));
    if (middle > cell.voltage_min_v - 1.0 && middle < cell.voltage_max_v + 0.6) continue;
    throw InputError(log.path, fmt::format("{} with a median of {:.3g} V for a cell", role, middle),
                     fmt::format("{} to {} V", cell.voltage_min_v, cell.voltage_max_v),
                     "Correct the unit in the map or the number of cells in series");
  }
  check_count(series, log);
}

}  // namespace voltlap::plant
