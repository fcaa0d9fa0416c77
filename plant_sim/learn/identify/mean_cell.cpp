// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/mean_cell.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

/// All parameters of a model in the order of the packed ones, R and tau as they are.
Eigen::VectorXd parameters_of(const CircuitModel& model) {
  Eigen::VectorXd out(model.em.size() + model.r.size() + model.tau.size());
  out << model.em, model.r.reshaped(), model.tau.reshaped();
  return out;
}

void take_parameters(const Eigen::VectorXd& p, CircuitModel& model) {
  model.em = p.head(model.em.size());
  model.r = p.segment(model.em.size(), model.r.size()).reshaped(model.r.rows(), model.r.cols());
  model.tau = p.tail(model.tau.size()).reshaped(model.tau.rows(), model.tau.cols());
}

/// A cell that was fitted with fewer branches has none of the others.
bool same_shape(const CellIdentification& a, const CellIdentification& b) {
  if (a.temperatures_c.size() != b.temperatures_c.size() || a.currents_a.size() != b.currents_a.size()) return false;
  if (a.points.size() != b.points.size()) return false;
  for (std::size_t g = 0; g < a.points.size(); ++g) {
    if (a.points[g].result.model.branches() != b.points[g].result.model.branches()) return false;
  }
  return true;
}

/// Where a cell stands on another's SOC: s_other = begin + length s.
struct SocScale {
  double begin = 0.0, length = 1.0;
};

/// The scale on which a cell's OCV lies best on the other's, over the SOC that both have.
SocScale scale_onto(const CircuitModel& cell, const CircuitModel& other) {
  constexpr int kPasses = 30;
  constexpr double kStep = 1e-4, kLeast = 0.02, kMost = 0.98;
  Eigen::Vector2d x(0.0, 1.0);
  for (int pass = 0; pass < kPasses; ++pass) {
    Eigen::Matrix2d n = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    for (Index k = 0; k < cell.ocv.size(); ++k) {
      const double soc = cell.ocv.at(k), at = x(0) + x(1) * soc;
      if (at < kLeast || at > kMost) continue;
      const double here = other.ocv.value(other.em, at);
      const double slope = (other.ocv.value(other.em, at + kStep) - here) / kStep;
      const Eigen::Vector2d row(slope, slope * soc);
      n += row * row.transpose();
      g += row * (cell.em(k) - here);
    }
    const Eigen::Vector2d step = n.ldlt().solve(g);
    x += step;
    x(1) = std::clamp(x(1), 0.7, 1.4);
    if (step.cwiseAbs().maxCoeff() < 1e-7) break;
  }
  return {x(0), x(1)};
}

/// The same cell with its SOC on the other scale; beyond its own ends the end values hold.
void rescale(const SocScale& scale, IdentifyResult& result) {
  CircuitModel& model = result.model;
  const CircuitModel was = model;
  VOLTLAP_DEMAND(was.em.size() == was.ocv.size() && was.r.rows() == was.grid.size() && scale.length > 0.0);
  const auto own = [&](double soc) { return (soc - scale.begin) / scale.length; };
  const auto moved = [&](const SocGrid& grid, const Eigen::VectorXd& y) {
    Eigen::VectorXd out(y.size());
    for (Index k = 0; k < y.size(); ++k) out(k) = grid.value(y, own(grid.at(k)));
    return out;
  };
  model.em = moved(was.ocv, was.em);
  // Beyond the ends the OCV goes on with its slope: a cell that stopped early was not flat there.
  constexpr double kStep = 0.01;
  for (Index k = 0; k < model.em.size(); ++k) {
    const double at = own(was.ocv.at(k)), inside = std::clamp(at, kStep, 1.0 - kStep);
    if (at >= 0.0 && at <= 1.0) continue;
    const double end = at < 0.0 ? 0.0 : 1.0;
    const double slope =
        (was.ocv.value(was.em, end) - was.ocv.value(was.em, inside)) / (end - inside);
    model.em(k) = was.ocv.value(was.em, end) + slope * (at - end);
  }
  for (Index c = 0; c < was.r.cols(); ++c) model.r.col(c) = moved(was.grid, was.r.col(c));
  for (Index c = 0; c < was.tau.cols(); ++c) model.tau.col(c) = moved(was.grid, was.tau.col(c));
  model.capacity_ah = was.capacity_ah / scale.length;
  for (RecordingResult& file : result.files) {
    file.soc_low = scale.begin + scale.length * file.soc_low;
    file.soc_high = scale.begin + scale.length * file.soc_high;
    file.anchor.soc = scale.begin + scale.length * file.anchor.soc;
    file.anchor.from += ", on the common OCV";
  }
}

/// All cells of a test in series stop with the weakest, and none begins quite full: by its own charge alone each
/// cell's SOC would run from 1 to 0. Their OCV curves are one: SOC is that of the cell which got emptiest.
void align(std::vector<CellIdentification>& cells, std::size_t g) {
  std::size_t emptiest = 0;
  const auto end_v = [&](std::size_t c) { return cells[c].points[g].result.model.em(0); };
  for (std::size_t c = 1; c < cells.size(); ++c) {
    if (end_v(c) < end_v(emptiest)) emptiest = c;
  }
  const CircuitModel other = cells[emptiest].points[g].result.model;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (c != emptiest) rescale(scale_onto(cells[c].points[g].result.model, other), cells[c].points[g].result);
  }
}

double sample_deviation(const std::vector<double>& values, double mean) {
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

/// Group `g` of all cells into `into`; returns the spread.
Eigen::VectorXd average_point(const std::vector<CellIdentification>& cells, const std::vector<std::string>& names,
                              std::size_t g, IdentifyResult& into) {
  const auto n = static_cast<double>(cells.size());
  std::vector<Eigen::VectorXd> all;
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(into.uncertainty.sigma.size()), share = variance;
  double square = 0.0, capacity = 0.0;
  into.files.clear();
  into.notes.clear();
  into.sections.clear();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const IdentifyResult& one = cells[c].points[g].result;
    all.push_back(parameters_of(one.model));
    const Index count = std::min(variance.size(), one.uncertainty.sigma.size());
    variance.head(count) += one.uncertainty.sigma.head(count).cwiseAbs2() / (n * n);
    share.head(count) += one.uncertainty.data_share.head(count) / n;
    square += one.rms_v * one.rms_v / n;
    capacity += one.model.capacity_ah / n;
    into.files.insert(into.files.end(), one.files.begin(), one.files.end());
    into.sections.insert(into.sections.end(), one.sections.begin(), one.sections.end());
    for (const std::string& note : one.notes) into.notes.push_back(names[c] + ": " + note);
  }
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(all.front().size());
  for (const Eigen::VectorXd& p : all) mean += p / n;
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(mean.size());
  for (const Eigen::VectorXd& p : all) spread += (p - mean).cwiseAbs2() / (n - 1.0);
  spread = spread.cwiseSqrt();
  const Index em = into.model.em.size();
  spread.tail(spread.size() - em).array() /= mean.tail(mean.size() - em).array();
  take_parameters(mean, into.model);
  into.model.capacity_ah = capacity;
  into.uncertainty = {variance.cwiseSqrt(), share};
  into.rms_v = std::sqrt(square);
  return spread;
}

/// Value of table `table` (0: Em on the breakpoints, then R and tau) of a spread at a breakpoint.
double spread_at(const CircuitModel& model, const Eigen::VectorXd& spread, Index table, Index node) {
  if (table == 0) return model.ocv.value(spread.head(model.em.size()), model.grid.at(node));
  return spread(model.em.size() + (table - 1) * model.grid.size() + node);
}

std::string name_of_table(const CircuitModel& model, Index table) {
  if (table == 0) return "em_v";
  const bool is_tau = table > model.branches() + 1;
  return is_tau ? fmt::format("tau{}_s", table - model.branches() - 1) : fmt::format("r{}_ohm", table - 1);
}

}  // namespace

MeanCell mean_cell(std::vector<CellIdentification> cells, const std::vector<std::string>& names) {
  VOLTLAP_DEMAND(cells.size() > 1 && names.size() == cells.size());
  MeanCell out{cells.front(), {}, {}, 0.0};
  for (std::size_t c = 1; c < cells.size(); ++c) {
    if (!same_shape(cells[0], cells[c])) {
      throw InputError(names[c], "other tests, temperatures or numbers of branches than those of " + names[0],
                       "the same tests of every cell: their tables are averaged place by place",
                       "Give the same tests of each cell, and --rc when the number of branches differs");
    }
  }
  for (std::size_t g = 0; g < cells[0].points.size(); ++g) align(cells, g);
  double mean = 0.0;
  for (const CellIdentification& cell : cells) {
    out.capacity_ah.push_back(cell.reference_point().result.model.capacity_ah);
    mean += out.capacity_ah.back() / static_cast<double>(cells.size());
  }
  out.capacity_spread_ah = sample_deviation(out.capacity_ah, mean);
  for (std::size_t g = 0; g < out.identified.points.size(); ++g) {
    out.spread.push_back(average_point(cells, names, g, out.identified.points[g].result));
  }
  out.identified.reference_point().result.notes.push_back(
      fmt::format("Mean of {} cells; capacity {:.3f} +- {:.3f} Ah (standard deviation between the cells).",
                  cells.size(), mean, out.capacity_spread_ah));
  return out;
}

std::string spread_text(const MeanCell& mean) {
  const OperatingPoint& point = mean.identified.reference_point();
  const CircuitModel& model = point.result.model;
  const Eigen::VectorXd& spread = mean.spread[mean.identified.reference];
  const Index tables = 2 * model.branches() + 2;
  std::string out = fmt::format("\nSpread between {} cells, standard deviation, at {:.1f} degC{}: capacity {:.3f} Ah\n"
                                "    SOC    Em [mV]",
                                mean.capacity_ah.size(), point.temperature_c,
                                point.current_a > 0.0 ? fmt::format(", {:.0f} A", point.current_a) : "",
                                mean.capacity_spread_ah);
  for (Index table = 1; table < tables; ++table) {
    const std::string name = name_of_table(model, table);
    out += fmt::format("{:>10}", name.substr(0, name.find('_')) + " [%]");
  }
  out += "\n";
  for (Index node = model.grid.size(); node-- > 0;) {
    out += fmt::format("  {:5.3f}  {:9.2f}", model.grid.at(node), 1e3 * spread_at(model, spread, 0, node));
    for (Index table = 1; table < tables; ++table)
      out += fmt::format("{:10.1f}", 100.0 * spread_at(model, spread, table, node));
    out += "\n";
  }
  return out;
}

std::string spread_comment(const MeanCell& mean) {
  VOLTLAP_DEMAND(mean.spread.size() == mean.identified.points.size());
  const CircuitModel& model = mean.identified.reference_point().result.model;
  const Eigen::VectorXd& spread = mean.spread[mean.identified.reference];
  std::string out = "\n# Spread between the cells on the SOC breakpoints, standard deviation: Em in mV, others in %.\n";
  for (Index table = 0; table < 2 * model.branches() + 2; ++table) {
    out += fmt::format("# {}:", name_of_table(model, table));
    for (Index node = 0; node < model.grid.size(); ++node)
      out += fmt::format(" {:.2f}", (table == 0 ? 1e3 : 100.0) * spread_at(model, spread, table, node));
    out += "\n";
  }
  return out;
}

std::string with_spread(const std::string& identification, const MeanCell& mean,
                        const std::vector<std::string>& cells) {
  VOLTLAP_DEMAND(mean.spread.size() == mean.identified.points.size());
  Json out = Json::parse(identification);
  out["capacity_spread_ah"] = mean.capacity_spread_ah;
  for (std::size_t g = 0; g < mean.spread.size(); ++g) {
    const CircuitModel& model = mean.identified.points[g].result.model;
    Json spread = Json::object();
    for (Index table = 0; table < 2 * model.branches() + 2; ++table) {
      Json& values = spread[name_of_table(model, table)] = Json::array();
      for (Index node = 0; node < model.grid.size(); ++node)
        values.push_back(spread_at(model, mean.spread[g], table, node));
    }
    out["tests"][g]["spread"] = spread;
  }
  for (const std::string& cell : cells) out["cells"].push_back(Json::parse(cell));
  return out.dump(2) + "\n";
}

std::string cell_of_file(const std::string& path) {
  static const std::regex pattern("_(cell[0-9]+)\\.csv(\\.gz)?$");
  std::smatch match;
  const std::string name = std::filesystem::path(path).filename().string();
  return std::regex_search(name, match, pattern) ? match[1].str() : "";
}

}  // namespace voltlap::plant
