// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

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

/// One value a node where there is one operating point, else [soc][temperature][current].
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

void set_axes(const CellIdentification& identified, CellParameters& cell) {
  cell.reference_temperature_c = identified.reference_point().temperature_c;
  cell.reference_current_a = identified.reference_point().current_a;
  cell.soc_breakpoints = breakpoint_grid().nodes();
  cell.temperature_breakpoints_c = identified.temperatures_c;
  cell.current_breakpoints_a = identified.currents_a;
  cell.kinetic_law = identified.temperatures_c.size() > 1 || identified.currents_a.size() > 1;
  VOLTLAP_DEMAND(increasing(cell.soc_breakpoints) && increasing(cell.current_breakpoints_a));
}

void set_voltage_limits(const std::vector<RecordingResult>& files, CellParameters& cell) {
  double low = 1e9, high = 0.0;
  for (const RecordingResult& file : files) {
    low = std::min(low, file.voltage_low_v);
    high = std::max(high, file.voltage_high_v);
  }
  cell.voltage_min_v = low;
  cell.voltage_max_v = high;
}

struct SocPassed {
  double low = 1.0, high = 0.0;
};
SocPassed soc_passed(const IdentifyResult& result) {
  SocPassed out;
  for (const RecordingResult& file : result.files) {
    out.low = std::min(out.low, file.soc_low);
    out.high = std::max(out.high, file.soc_high);
  }
  return out;
}

/// Where nothing was driven the OCV goes on as that of the plain circuit: the ends of a curve that was fitted beside
/// resistances over SOC take a part of these. Below a charge that is only what was drawn, by the slope that the plain
/// one has near its end (docs/estimation_methods.md: the second half of a drive from its first).
void go_on_as_plain(const IdentifyResult& reference, const SocPassed& passed, const std::vector<double>& soc,
                    Eigen::VectorXd& ocv, std::vector<std::string>& notes) {
  constexpr double kNear = 0.1;  // of the charge that was drawn
  if (!reference.plain) return;
  const auto plain = [&](double at) { return reference.plain->ocv.value(reference.plain->em, at); };
  const auto model = [&](double at) { return reference.model.ocv.value(reference.model.em, at); };
  for (Index k = 0; k < ocv.size(); ++k) {
    const double at = soc[static_cast<std::size_t>(k)], end = std::clamp(at, passed.low, passed.high);
    if (at != end) ocv(k) = model(end) + plain(at) - plain(end);
  }
  if (!reference.capacity.is_lower_bound()) return;
  const double slope_v = std::max(0.0, (plain(kNear) - plain(0.0)) / kNear);
  ocv(0) = ocv(1) - slope_v * (soc[1] - soc[0]);
  notes.push_back(fmt::format("Below the charge that was drawn the OCV is assumed to fall by {:.3g} mV per Ah, as that "
                              "of a plain circuit does near its end.",
                              1e3 * slope_v / reference.model.capacity_ah));
}

/// The reference's curve, levelled where it falls with SOC.
void set_ocv(const IdentifyResult& reference, CellParameters& cell, std::vector<std::string>& notes) {
  constexpr double kNoCurve = 1.0, kWorthANote = 1e-3;  // V; beyond the first this is no open-circuit voltage
  const CircuitModel& model = reference.model;
  const SocPassed passed = soc_passed(reference);
  cell.ocv_soc = fine(model.ocv.nodes());
  Eigen::VectorXd ocv(static_cast<Index>(cell.ocv_soc.size()));
  for (Index k = 0; k < ocv.size(); ++k) {
    const double soc = cell.ocv_soc[static_cast<std::size_t>(k)];
    ocv(k) = model.ocv.value(model.em, soc);
  }
  go_on_as_plain(reference, passed, cell.ocv_soc, ocv, notes);
  for (Index k = 0; k < ocv.size(); ++k) {
    const double soc = cell.ocv_soc[static_cast<std::size_t>(k)];
    // Beyond the SOC that was passed it may lead anywhere.
    if (soc < passed.low || soc > passed.high) ocv(k) = std::clamp(ocv(k), cell.voltage_min_v, cell.voltage_max_v);
  }
  cell.ocv_v = not_falling(ocv);
  VOLTLAP_DEMAND(increasing(cell.ocv_soc) && cell.ocv_v.size() == cell.ocv_soc.size() && all_finite(cell.ocv_v));
  double levelled = 0.0;
  for (std::size_t k = 0; k < cell.ocv_v.size(); ++k)
    levelled = std::max(levelled, std::abs(cell.ocv_v[k] - ocv(static_cast<Index>(k))));
  if (levelled > kNoCurve) {
    throw InputError(reference.files.front().path,
                     fmt::format("an OCV that falls by {:.2g} V as SOC rises: no rest tells it", levelled),
                     "recordings with rests of four minutes or more between the pulses",
                     "Give such a recording, or the OCV of the cell with --ocv");
  }
  if (levelled > kWorthANote)
    notes.push_back(fmt::format("The OCV fell with SOC in places; levelled by up to {:.1f} mV.", 1e3 * levelled));
}

void set_tables(const CellIdentification& identified, CellParameters& cell) {
  constexpr double kLeast = 1e-7;  // ohm, that a cell file may hold
  const Index branches = identified.reference_point().result.model.branches();
  VOLTLAP_DEMAND(branches >= 1 && branches <= static_cast<Index>(cell.branches.size()));
  const auto resistance = [&](Index column) {
    return table_of(identified, [&](const CircuitModel& m, Index node) {
      VOLTLAP_DEMAND(m.branches() == branches);  // tables of different circuits do not mix
      return std::max(kLeast, m.r(node, column));
    });
  };
  cell.r0_ohm = resistance(0);
  for (Index k = 0; k < branches; ++k) {
    CellBranch& branch = cell.branches[static_cast<std::size_t>(k)];
    branch.r_ohm = resistance(k + 1);
    branch.tau_s = table_of(identified, [&](const CircuitModel& m, Index node) { return m.tau(node, k); });
  }
  const auto ocv = [](const CircuitModel& m, Index node) { return m.ocv.value(m.em, m.grid.at(node)); };
  cell.ocv_table_v = table_of(identified, ocv).table;
}

/// Points from the coldest to the warmest that was tested and 20 K beyond, about 5 K apart, the reference among them:
/// between them the plant follows the laws.
std::vector<double> temperature_points(double coldest_c, double reference_c, double warmest_c) {
  constexpr double kReach = 20.0, kApart = 5.0;
  VOLTLAP_DEMAND(coldest_c <= reference_c && reference_c <= warmest_c);
  std::vector<double> out;
  const double below = reference_c - coldest_c + kReach, above = warmest_c + kReach - reference_c;
  const auto cold = static_cast<int>(std::ceil(below / kApart)), warm = static_cast<int>(std::ceil(above / kApart));
  for (int k = cold; k > 0; --k) out.push_back(reference_c - below * k / cold);
  for (int k = 0; k <= warm; ++k) out.push_back(reference_c + above * k / warm);
  return out;
}

/// One table over SOC and laws: values at the reference point, and what they do over temperature and current.
void set_laws(const OperatingPoint& point, CellParameters& cell) {
  constexpr double kJoules = 1e3, kMillivolt = 1e-3;
  const ResistanceLaws& laws = point.result.model.laws;
  cell.r0_ohm.activation_energy_j_per_mol = kJoules * laws.ohmic_kj_per_mol;
  for (std::size_t k = 0; k < cell.branch_count(); ++k) {
    cell.branches[k].r_ohm.activation_energy_j_per_mol = kJoules * laws.branch_kj_per_mol[k].resistance;
    cell.branches[k].tau_s.activation_energy_j_per_mol = kJoules * laws.branch_kj_per_mol[k].time_constant;
  }
  double coldest = point.temperature_c, warmest = coldest, most = 0.0;
  for (const RecordingResult& file : point.result.files) {
    coldest = std::min(coldest, file.coldest_c);
    warmest = std::max(warmest, file.warmest_c);
    most = std::max(most, file.trace.current_a.cwiseAbs().maxCoeff());
  }
  const bool moves = laws.has_temperature();
  if (laws.has_hysteresis()) {
    cell.effects.hysteresis_v = kMillivolt * laws.hysteresis_mv;
    cell.effects.hysteresis_per_soc = laws.hysteresis_per_soc;
  }
  cell.effects.entropy_v_per_k = kMillivolt * laws.entropy_mv_per_k;
  cell.kinetic_law = moves || laws.has_charge_transfer();
  if (moves) cell.temperature_breakpoints_c = temperature_points(coldest, point.temperature_c, warmest);
  if (!laws.has_charge_transfer()) return;
  cell.r0_ohm.exchange_current_a = laws.exchange_a;
  cell.r0_ohm.exchange_activation_energy_j_per_mol = kJoules * laws.branch_kj_per_mol[0].resistance;
  cell.current_breakpoints_a.clear();
  for (const double share : {0.05, 0.2, 0.5, 1.0}) cell.current_breakpoints_a.push_back(share * most);
}

/// What a cell file holds is finite, or there is none.
void require_finite(const CellParameters& cell, const std::vector<RecordingResult>& files) {
  const auto check = [&](const std::string& key, const std::vector<double>& values) {
    if (all_finite(values)) return;
    const std::string path = files.empty() ? cell.name : files.front().path;
    throw InputError(path, key + " that is no finite number", "recordings that determine it",
                     "Give a longer recording with more steps of the current, or fewer branches (--rc 1)");
  };
  check("a capacity", {cell.capacity_ah});
  check("a highest or lowest voltage", {cell.voltage_min_v, cell.voltage_max_v});
  check("a mass, heat capacity or surface",
        {cell.mass_kg, cell.heat_capacity_j_per_kg_k, cell.surface_area_m2, cell.convection_w_per_m2_k,
         cell.surface_lag_s});
  check("a reference temperature or current", {cell.reference_temperature_c, cell.reference_current_a});
  for (const auto& [key, values] : {std::pair{"a temperature", &cell.temperature_breakpoints_c},
                                    {"a current", &cell.current_breakpoints_a},
                                    {"an OCV", &cell.ocv_v},
                                    {"an OCV table", &cell.ocv_table_v}})
    check(key, *values);
  const auto check_map = [&](const std::string& key, const CellParameterMap& map) {
    check(key, map.value);
    check(key, map.table);
  };
  check_map("r0", cell.r0_ohm);
  for (std::size_t k = 0; k < cell.branch_count(); ++k) {
    check_map(fmt::format("r{}", k + 1), cell.branches[k].r_ohm);
    check_map(fmt::format("tau{}", k + 1), cell.branches[k].tau_s);
  }
}

}  // namespace

CellParameters cell_parameters(const CellIdentification& identified, const CellBody& body,
                               const std::string& name, std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!identified.points.empty() && identified.reference < identified.points.size());
  const OperatingPoint& reference = identified.reference_point();
  CellParameters cell;
  cell.name = name;
  cell.capacity_ah = reference.result.model.capacity_ah;
  body.write_into(cell);
  set_axes(identified, cell);
  set_voltage_limits(reference.result.files, cell);
  set_ocv(reference.result, cell, notes);
  set_tables(identified, cell);
  if (identified.points.size() == 1) set_laws(reference, cell);
  require_finite(cell, reference.result.files);
  for (std::string& what : implausible(cell, body)) notes.push_back(std::move(what));
  return cell;
}

OcvPolynomial ocv_polynomial(const CircuitModel& model) {
  constexpr Index kOrder = 5;
  VOLTLAP_DEMAND(model.em.size() == model.ocv.size() && model.ocv.size() > kOrder);
  const Index n = model.ocv.size();
  Eigen::MatrixXd powers(n, kOrder + 1);
  for (Index row = 0; row < n; ++row) {
    for (Index k = 0; k <= kOrder; ++k) powers(row, k) = std::pow(model.ocv.at(row), static_cast<double>(k));
  }
  const Eigen::VectorXd c = powers.colPivHouseholderQr().solve(model.em);
  return {{c.begin(), c.end()}, (powers * c - model.em).cwiseAbs().maxCoeff()};
}

}  // namespace voltlap::plant
