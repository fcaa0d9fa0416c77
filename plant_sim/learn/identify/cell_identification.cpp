// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/cell_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <future>

#include "core/errors.hpp"
#include "learn/identify/common_time_constants.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kSameTemperature = 4.0, kSameCurrent = 0.2;  // K; relative

/// The one discharge current of a test, or 0 when it draws several.
double single_current(const CellLog& log) {
  std::vector<double> drawn;
  double most = 0.0;
  for (const double i : log.current_a) most = std::max(most, i);
  for (const double i : log.current_a) {
    if (i > 0.05 * most) drawn.push_back(i);
  }
  if (drawn.size() < 10) return 0.0;
  std::sort(drawn.begin(), drawn.end());
  // A resistor's current falls with the voltage, most in the last pulse: a third between a tenth and nine tenths of the
  // rows is still one test.
  const double low = drawn[drawn.size() / 10], high = drawn[drawn.size() * 9 / 10],
               middle = drawn[drawn.size() / 2];
  return high - low < 0.35 * middle ? middle : 0.0;
}

/// A recording without a fast current tells the OCV and the capacity, but no resistance: it makes no group of its own.
bool is_slow(const CellLog& log) {
  constexpr double kSlow = 1.0 / 8.0;  // C-rate
  double most = 0.0;
  for (const double i : log.current_a) most = std::max(most, std::abs(i));
  const std::vector<double> drawn = charge_drawn_ah(log, CurrentHold::kLinear);
  const auto [low, high] = std::minmax_element(drawn.begin(), drawn.end());
  return most < kSlow * (*high - *low);
}

/// Those of the values whose recordings are fast; all of them when none is.
std::vector<double> of_fast(const std::vector<double>& values, const std::vector<bool>& slow) {
  std::vector<double> out;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!slow[k]) out.push_back(values[k]);
  }
  return out.empty() ? values : out;
}

template <class Same>
std::vector<double> clusters(std::vector<double> values, const Same& same) {
  std::sort(values.begin(), values.end());
  std::vector<double> centres, members;
  for (const double value : values) {
    if (!members.empty() && !same(members.front(), value)) {
      centres.push_back(members[members.size() / 2]);
      members.clear();
    }
    members.push_back(value);
  }
  centres.push_back(members[members.size() / 2]);
  return centres;
}

std::size_t nearest(const std::vector<double>& centres, double value) {
  const auto by_distance = [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); };
  return static_cast<std::size_t>(std::min_element(centres.begin(), centres.end(), by_distance) - centres.begin());
}

/// Pool of adjacent violators: the nearest curve that does not fall.
std::vector<double> not_falling(const Eigen::VectorXd& y) {
  struct Pool {
    double sum;
    std::size_t count;
    [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
  };
  std::vector<Pool> pools;
  for (const double value : y) {
    pools.push_back({value, 1});
    while (pools.size() > 1 && pools[pools.size() - 2].mean() > pools.back().mean()) {
      const Pool last = pools.back();
      pools.pop_back();
      pools.back().sum += last.sum;
      pools.back().count += last.count;
    }
  }
  std::vector<double> out;
  for (const Pool& pool : pools) out.insert(out.end(), pool.count, pool.mean());
  return out;
}

/// Nodes of a curve that a table, straight between its entries, is to follow: three more in each interval.
std::vector<double> fine(const std::vector<double>& at) {
  constexpr int kParts = 4;
  std::vector<double> out{at.front()};
  for (std::size_t k = 1; k < at.size(); ++k) {
    for (int part = 1; part <= kParts; ++part) out.push_back(at[k - 1] + (at[k] - at[k - 1]) * part / kParts);
  }
  return out;
}

CellParameterMap table_of(const CellIdentification& identified, const auto& value_at) {
  CellParameterMap map;
  const Index nodes = breakpoint_grid().size();
  if (identified.temperatures_c.size() == 1 && identified.currents_a.size() == 1) {
    for (Index node = 0; node < nodes; ++node) map.value.push_back(value_at(identified.points[0].result.model, node));
    return map;
  }
  for (Index node = 0; node < nodes; ++node) {
    for (std::size_t t = 0; t < identified.temperatures_c.size(); ++t) {
      for (std::size_t i = 0; i < identified.currents_a.size(); ++i) {
        map.table.push_back(value_at(identified.at(t, i).result.model, node));
      }
    }
  }
  return map;
}

}  // namespace

const OperatingPoint& CellIdentification::at(std::size_t temperature, std::size_t current) const {
  const OperatingPoint* best = nullptr;
  double least = 1e300;
  for (const OperatingPoint& point : points) {
    const double dt = (point.temperature_c - temperatures_c[temperature]) / 10.0;
    const double di = std::log((point.current_a + 1.0) / (currents_a[current] + 1.0));
    // A neighbour in current is nearer than one in temperature: tables change little with current.
    const double distance = std::abs(dt) + 0.01 * std::abs(di);
    if (distance < least) {
      least = distance;
      best = &point;
    }
  }
  return *best;
}

bool CellIdentification::was_tested(std::size_t temperature, std::size_t current) const {
  const OperatingPoint& point = at(temperature, current);
  return std::abs(point.temperature_c - temperatures_c[temperature]) < 1e-9 &&
         std::abs(point.current_a - currents_a[current]) < 1e-9;
}

CellIdentification identify_cell(std::vector<CellLog> logs, const std::vector<double>& temperatures_c,
                        const IdentifyOptions& options) {
  CellIdentification identified;
  std::vector<double> currents;
  std::vector<bool> slow;
  for (const CellLog& log : logs) {
    currents.push_back(single_current(log));
    slow.push_back(is_slow(log));
  }
  const std::vector<double> told = of_fast(currents, slow);
  const bool by_current = std::all_of(told.begin(), told.end(), [](double i) { return i > 0.0; });
  if (!by_current) std::fill(currents.begin(), currents.end(), 0.0);
  identified.temperatures_c =
      clusters(of_fast(temperatures_c, slow), [](double a, double b) { return b - a < kSameTemperature; });
  identified.currents_a =
      clusters(of_fast(currents, slow), [](double a, double b) { return b - a <= kSameCurrent * a; });
  for (std::size_t t = 0; t < identified.temperatures_c.size(); ++t) {
    for (std::size_t i = 0; i < identified.currents_a.size(); ++i) {
      OperatingPoint point{identified.temperatures_c[t], identified.currents_a[i], {}, {}};
      for (std::size_t k = 0; k < logs.size(); ++k) {
        const bool here =
            nearest(identified.temperatures_c, temperatures_c[k]) == t && nearest(identified.currents_a, currents[k]) == i;
        if (here) point.logs.push_back(std::move(logs[k]));
      }
      if (!point.logs.empty()) identified.points.push_back(std::move(point));
    }
  }
  constexpr double kUsual = 25.0;
  for (std::size_t g = 1; g < identified.points.size(); ++g) {
    const auto distance = [&](std::size_t k) { return std::abs(identified.points[k].temperature_c - kUsual); };
    if (distance(g) < distance(identified.reference)) identified.reference = g;
  }
  OperatingPoint& reference = identified.points[identified.reference];
  const auto own_options = [&](const OperatingPoint& point, IdentifyOptions own) {
    own.reference_temperature_c = point.temperature_c;
    return own;
  };
  reference.result = identify(reference.logs, own_options(reference, options));
  if (identified.points.size() == 1) return identified;
  IdentifyOptions others = options;
  others.capacity_ah = reference.result.model.capacity_ah;
  // Every group with the same number of branches: tables of different circuits do not mix.
  others.branches = static_cast<int>(reference.result.model.branches());
  others.progress = nullptr;
  std::vector<std::future<IdentificationProblem>> preparing;
  for (const OperatingPoint& point : identified.points) {
    IdentifyOptions own = own_options(point, others);
    if (&point == &reference) own.capacity_ah = options.capacity_ah;
    preparing.push_back(std::async(std::launch::async, [&point, own] { return IdentificationProblem(point.logs, own); }));
  }
  std::vector<IdentificationProblem> ready;
  for (auto& one : preparing) ready.push_back(one.get());
  const bool together = !options.method && !options.constant;
  if (together && options.progress) options.progress("time constants of all tests together");
  std::vector<double> temperatures;
  for (const OperatingPoint& point : identified.points) temperatures.push_back(point.temperature_c);
  const std::vector<Eigen::VectorXd> taus =
      together ? common_time_constants(ready, temperatures, others.branches) : std::vector<Eigen::VectorXd>{};
  IdentifyResult alone = reference.result;
  std::vector<std::future<void>> running;
  for (std::size_t g = 0; g < identified.points.size(); ++g) {
    if (!together && g == identified.reference) continue;
    running.push_back(std::async(std::launch::async, [&, g] {
      std::optional<Eigen::VectorXd> centre;
      if (together) centre = taus[g];
      identified.points[g].result = std::move(ready[g]).fit(centre);
    }));
  }
  for (auto& one : running) one.get();
  if (together) {
    // How many branches there are was found before; it is told with the rest.
    reference.result.orders = std::move(alone.orders);
    for (const std::string& note : alone.notes) {
      auto& notes = reference.result.notes;
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
    }
    const Eigen::VectorXd& found = taus[identified.reference];
    std::vector<std::string> seconds;
    for (const double tau : found) seconds.push_back(fmt::format("{:.3g}", tau));
    reference.result.notes.push_back(
        fmt::format("Time constants around {} s at {:.0f} degC, looked for in all {} tests together.",
                    fmt::join(seconds, " and "), reference.temperature_c, identified.points.size()));
  }
  return identified;
}

CellParameters cell_parameters(const CellIdentification& identified, const CellParameters& like, const std::string& name,
                               std::vector<std::string>& notes) {
  const OperatingPoint& reference = identified.points[identified.reference];
  const CircuitModel& model = reference.result.model;
  CellParameters cell = like;
  // Size by charge: mass goes with it, surface with its two-thirds power.
  const double size = model.capacity_ah / like.capacity_ah;
  cell.name = name;
  cell.capacity_ah = model.capacity_ah;
  cell.mass_kg = like.mass_kg * size;
  cell.surface_area_m2 = like.surface_area_m2 * std::pow(size, 2.0 / 3.0);
  cell.reference_temperature_c = reference.temperature_c;
  cell.reference_current_a = reference.current_a;
  cell.soc_breakpoints = breakpoint_grid().nodes();
  cell.temperature_breakpoints_c = identified.temperatures_c;
  cell.current_breakpoints_a = identified.currents_a;
  cell.kinetic_law = identified.temperatures_c.size() > 1 || identified.currents_a.size() > 1;
  double low = 1e9, high = 0.0;
  for (const RecordingResult& file : reference.result.files) {
    low = std::min(low, file.voltage_low_v);
    high = std::max(high, file.voltage_high_v);
  }
  cell.voltage_min_v = low;
  cell.voltage_max_v = high;
  cell.ocv_polynomial_v.clear();
  cell.ocv_soc = fine(model.ocv.nodes());
  Eigen::VectorXd ocv(static_cast<Index>(cell.ocv_soc.size()));
  for (Index k = 0; k < ocv.size(); ++k) ocv(k) = model.ocv.value(model.em, cell.ocv_soc[static_cast<std::size_t>(k)]);
  cell.ocv_v = not_falling(ocv);
  double levelled = 0.0;
  for (std::size_t k = 0; k < cell.ocv_v.size(); ++k)
    levelled = std::max(levelled, std::abs(cell.ocv_v[k] - ocv(static_cast<Index>(k))));
  constexpr double kNoCurve = 1.0;  // V; beyond it this is no open-circuit voltage
  if (levelled > kNoCurve) {
    throw InputError(reference.result.files.front().path,
                     fmt::format("an OCV that falls by {:.2g} V as SOC rises: no rest tells it", levelled),
                     "recordings with rests of four minutes or more between the pulses",
                     "Give such a recording, or the OCV of the cell with --ocv");
  }
  if (levelled > 1e-3)
    notes.push_back(fmt::format("The OCV fell with SOC in places; levelled by up to {:.1f} mV.", 1e3 * levelled));

  constexpr double kNoResistance = 1e-7, kNoTau = 1.0;  // a branch that is not there
  const auto resistance = [&](Index column) {
    return table_of(identified, [&](const CircuitModel& m, Index node) {
      return column < m.r.cols() ? std::max(kNoResistance, m.r(node, column)) : kNoResistance;
    });
  };
  const auto tau = [&](Index column) {
    return table_of(identified, [&](const CircuitModel& m, Index node) {
      return column < m.tau.cols() ? m.tau(node, column) : kNoTau;
    });
  };
  cell.r0_ohm = resistance(0);
  cell.r1_ohm = resistance(1);
  cell.r2_ohm = resistance(2);
  cell.tau1_s = tau(0);
  cell.tau2_s = tau(1);
  cell.ocv_table_v = table_of(identified, [](const CircuitModel& m, Index node) {
                       return m.ocv.value(m.em, m.grid.at(node));
                     }).table;
  if (identified.temperatures_c.size() == 1) {
    // One temperature was tested: the resistances follow the stated coefficient within 20 K, the tables hold at its
    // ends.
    constexpr double kReach = 20.0;
    cell.temperature_breakpoints_c = {reference.temperature_c - kReach, reference.temperature_c,
                                      reference.temperature_c + kReach};
    for (CellParameterMap* map : {&cell.r0_ohm, &cell.r1_ohm, &cell.r2_ohm}) map->per_kelvin = model.per_kelvin;
    if (!cell.r0_ohm.table.empty()) cell.temperature_breakpoints_c = {reference.temperature_c};
  }
  return cell;
}

OcvPolynomial ocv_polynomial(const CircuitModel& model) {
  constexpr Index kOrder = 5;
  const Index n = model.ocv.size();
  Eigen::MatrixXd powers(n, kOrder + 1);
  for (Index row = 0; row < n; ++row) {
    for (Index k = 0; k <= kOrder; ++k) powers(row, k) = std::pow(model.ocv.at(row), static_cast<double>(k));
  }
  const Eigen::VectorXd c = powers.colPivHouseholderQr().solve(model.em);
  return {{c.begin(), c.end()}, (powers * c - model.em).cwiseAbs().maxCoeff()};
}

namespace {

bool was_passed(const IdentifyResult& result, double soc) {
  double low = 1.0, high = 0.0;
  for (const RecordingResult& file : result.files) {
    low = std::min(low, file.soc_low);
    high = std::max(high, file.soc_high);
  }
  return soc > low - 0.01 && soc < high + 0.01;
}

constexpr double kTwoSided = 1.96;

}  // namespace

bool is_excited(const IdentifyResult& result, Index table, Index node) {
  constexpr double kSeries = 0.01, kBranch = 0.05, kTau = 0.10;
  const double narrow = table == 0 ? kSeries : table <= result.model.branches() ? kBranch : kTau;
  const Index at = result.model.em.size() + table * result.model.grid.size() + node;
  return was_passed(result, result.model.grid.at(node)) && kTwoSided * result.uncertainty.sigma(at) < narrow;
}

bool is_ocv_excited(const IdentifyResult& result, Index node) {
  constexpr double kNarrow = 2e-3;  // V
  return was_passed(result, result.model.ocv.at(node)) && kTwoSided * result.uncertainty.sigma(node) < kNarrow;
}

}  // namespace voltlap::plant
