// SPDX-License-Identifier: Apache-2.0
// A cause of discrepancy: what it is, its parameters with what is physically possible, the forms in which it can
// appear on a given log, and how it changes the simulated world. One file of causes/ each.
#pragma once
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "explain/balances/balances.hpp"

namespace voltlap::plant {

using Values = std::span<const double>;

inline constexpr double kUsualOhm = 3e-3;  // a cell of 30 Ah

/// A number of a cause. `low` and `high` are the prior: beyond them the cause is not believed.
struct CauseParameter {
  const char* name;
  const char* unit;
  double low, high;
  double typical;            ///< a usual size: step of derivatives, width of the prior of the linear stage
  double shown_scale = 1.0;  ///< in sentences
  const char* shown_unit = "";
  bool of_cell = false;  ///< ohms, typical for a cell of kUsualOhm: a cell with more resistance has more of it
};

/// Away from the ends of the prior, where the prior is what is told. From an end that is zero every size is away;
/// what is always positive, as a time constant, is measured in logarithms.
[[nodiscard]] inline bool is_inside_prior(const CauseParameter& p, double value) {
  constexpr double kMargin = 0.02;  // of the prior's width
  if (p.low > 0.0) {
    const double place = std::log(value / p.low) / std::log(p.high / p.low);
    return place >= kMargin && place <= 1.0 - kMargin;
  }
  const double width = p.high - p.low;  // of a lopsided prior the nearer end counts on its own side
  const double low = kMargin * std::min(width, 2.0 * std::abs(p.low)),
               high = kMargin * std::min(width, 2.0 * std::abs(p.high));
  return (p.low == 0.0 ? value > 0.0 : value >= p.low + low) &&
         (p.high == 0.0 ? value < 0.0 : value <= p.high - high);
}

/// One way in which a cause can act on this log.
struct Form {
  std::string channel;                        ///< the channel that is wrong, or empty
  std::vector<double> at;                     ///< start value of every parameter
  std::vector<std::size_t> linear;            ///< parameters that the linear stage estimates
  std::vector<std::size_t> refined;           ///< parameters that the nonlinear stage estimates
  std::function<void(World&, Values)> apply;  ///< on everything; or:
  std::string stem = {};                      ///< on one member of this group, any of them:
  std::vector<double> read = {};              ///< standard deviations of parameters that the log itself says
  const char* says = nullptr;  ///< in the place of the cause's sentence
  double bend = 0.0;       ///< of the linear parameters as points of a curve: a usual second difference
  bool of_sensor = false;  ///< what it reads, not what it is: the pack's voltage does not have it
  /// effect of one unit of each linear parameter on the member's reading
  std::function<std::vector<Eigen::VectorXd>(const World&, const Comparison&, const Prediction&)> shapes = {};
  /// where that bends: whole effect of these values
  std::function<Eigen::VectorXd(const World&, const Comparison&, const Prediction&, Values)> curved = {};
};

struct Cause {
  const char* name;
  Balance balance;
  const char* says;  ///< sentence; {} takes the parameters in turn, {channel} the channel or the cell
  const char* test;  ///< manoeuvre that shows it best
  std::vector<CauseParameter> parameters;
  std::function<std::vector<Form>(const World&, const Comparison&)> forms;
  /// A part of the cells' voltage that `identify` fits to a log together with the others: their sum is right there,
  /// and one may be too much for another that is too little.
  bool is_identified = false;
  /// One of the laws of the cells' series resistance. What one is too much another is too little in a model that is
  /// right on average: together they are one error, of its table.
  bool is_law_of_resistance = false;
  /// Other numbers than the parameters themselves are reported: their descriptions, and their values from the
  /// parameters.
  std::vector<CauseParameter> reported = {};
  std::function<std::vector<double>(Values)> report = {};
  /// What a model's cell has of the first parameter: a change takes away at most that. Else the prior's low end
  /// holds.
  std::function<double(const CellParameters&)> present = {};
  /// A cause in one cell (from 0): puts it into the model that is written.
  std::function<void(VehicleParameters&, std::size_t cell, Values)> extend = {};
};

/// Variation of one cell of a car, with a place for it.
[[nodiscard]] inline CellVariation& cell_variation(VehicleParameters& car, std::size_t cell) {
  if (car.battery.cells.size() <= cell) car.battery.cells.resize(cell + 1);
  return car.battery.cells[cell];
}

/// A form that acts on everything with all its parameters linear.
[[nodiscard]] inline Form plain_form(std::size_t parameters, std::function<void(World&, Values)> apply) {
  Form form;
  form.apply = std::move(apply);
  form.at.assign(parameters, 0.0);
  for (std::size_t k = 0; k < parameters; ++k) form.linear.push_back(k);
  form.refined = form.linear;
  return form;
}

/// The form, and where the log's SOC is judged also one that leaves that SOC alone: a BMS that counts the logged
/// current.
[[nodiscard]] inline std::vector<Form> with_counted_soc(const Form& form, const Comparison& c) {
  if (c.find("soc") == nullptr) return {form};
  Form counted = form;
  counted.apply = [plain = form.apply](World& w, Values v) {
    if (!w.soc_is_counted) w.counted_ah = w.car.cell.capacity_ah;
    w.soc_is_counted = true;
    plain(w, v);
  };
  return {form, counted};
}

/// The SOC that the model has in this log, by row.
[[nodiscard]] inline Eigen::VectorXd driven_soc(const World& model, const Comparison& c) {
  return c.soc.size() > 0 ? c.soc : predict(model, c).battery.soc;
}

/// The form, and where the log's SOC is judged also one for a BMS that began by the curve of the model: its charge is
/// wrong by what the form changes of that.
[[nodiscard]] inline std::vector<Form> with_begun_soc(const Form& form, const World& model, const Comparison& c) {
  if (c.find("soc") == nullptr) return {form};
  Form begun = form;
  begun.apply = [plain = form.apply, from = driven_soc(model, c)(0)](World& w, Values v) {
    w.reported_from_soc = from;
    plain(w, v);
  };
  return {form, begun};
}

/// All resistance that a cell has in the cold, 20 K below the temperature of its tables [ohm]: no change takes away
/// more.
[[nodiscard]] double cold_resistance(const CellParameters& cell);

/// Where a thermistor is recorded.
[[nodiscard]] inline bool has_temperature(const Comparison& c) {
  return c.find("temperature") != nullptr;
}

}  // namespace voltlap::plant
