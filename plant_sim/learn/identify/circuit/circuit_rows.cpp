// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/circuit/circuit_rows.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/parameters.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr int kMostNodes = 31;  // the breakpoints, halved
constexpr int kMostBranches = static_cast<int>(kMostCellBranches);
constexpr double kQuiet = 0.01;  // of the largest current: below it a row is at rest

CircuitRow::Place place_of(const SocGrid& grid, double soc) {
  const SocGrid::Place p = grid.find(soc);
  return {static_cast<int>(p.node), p.fraction};
}

double between(const double* y, const CircuitRow::Place& p) {
  return y[p.node] + p.fraction * (y[p.node + 1] - y[p.node]);
}

/// One branch on its way through a run: voltage and its derivatives by each node's R and tau, from node low to high,
/// and by the two laws that move it.
struct Branch {
  double v = 0.0, u = 0.0, decay = 1.0, by_energy = 0.0, by_tau_energy = 0.0;
  int low = 0, high = -1;
  std::array<double, kMostNodes> by_r{}, by_tau{};

  void begin(double voltage, double source) {
    v = voltage;
    u = source;
    decay = 1.0;
    by_energy = by_tau_energy = 0.0;
    low = 0;
    high = -1;
    by_r.fill(0.0);
    by_tau.fill(0.0);
  }
  void open(const CircuitRow::Place& p) {
    low = high < low ? p.node : std::min(low, p.node);
    high = std::max(high, p.node + 1);
  }
  void scale(double a) {
    for (int k = low; k <= high; ++k) {
      by_r[static_cast<std::size_t>(k)] *= a;
      by_tau[static_cast<std::size_t>(k)] *= a;
    }
  }
  static void put(std::array<double, kMostNodes>& into, const CircuitRow::Place& p, double value) {
    into[static_cast<std::size_t>(p.node)] += value * (1.0 - p.fraction);
    into[static_cast<std::size_t>(p.node) + 1] += value * p.fraction;
  }
  /// Ends at which the derivatives have died away are closed again.
  void close(double negligible_a, double negligible_v_per_s) {
    const auto dead = [&](int k) {
      return std::abs(by_r[static_cast<std::size_t>(k)]) < negligible_a &&
             std::abs(by_tau[static_cast<std::size_t>(k)]) < negligible_v_per_s;
    };
    const auto clear = [&](int k) { by_r[static_cast<std::size_t>(k)] = by_tau[static_cast<std::size_t>(k)] = 0.0; };
    for (; low <= high && dead(low); ++low) clear(low);
    for (; low <= high && dead(high); --high) clear(high);
  }
};

/// What the laws make of a row: currents that a table's resistance takes, factor of the time constants, and the
/// voltage's derivatives by the laws that act at once.
struct LawRow {
  double drop_a, tau_warm = 0.0;
  std::array<double, kMostBranches> begin_a{}, end_a{}, tau_factor{};
  const DoubtedRow* doubted = nullptr;  ///< where SOC is in doubt: how far it is off, and the OCV's slope
  double soc_off = 0.0, slope_v = 0.0;
  double taken_v = 0.0, by_ohmic = 0.0, by_first_branch = 0.0, by_log_exchange = 0.0;
};

constexpr double kMillivolt = 1e-3;

LawRow law_row(const CircuitRows& all, const CircuitRow& row, const double* laws, double r0_ohm,
               std::size_t branches) {
  LawRow out{row.current_a};
  for (std::size_t k = 0; k < branches; ++k) {
    const double energy = laws[ResistanceLaws::resistance(static_cast<Index>(k))],
                 of_tau = laws[ResistanceLaws::time_constant(static_cast<Index>(k))];
    out.begin_a[k] = all.isothermal ? row.begin_a : row.begin_a * std::exp(energy * row.warm_was);
    out.end_a[k] = all.isothermal ? row.end_a : row.end_a * std::exp(energy * row.warm);
    out.tau_factor[k] = all.isothermal ? 1.0 : std::exp(of_tau * row.warm);
  }
  if (!all.isothermal) {
    out.drop_a *= std::exp(laws[ResistanceLaws::kOhmic] * row.warm);
    out.tau_warm = row.warm;
    out.by_ohmic = -r0_ohm * out.drop_a * row.warm;
    out.taken_v = -kMillivolt * laws[ResistanceLaws::kEntropy] * row.warmer_k;
  }
  if (all.hysteresis) out.taken_v += kMillivolt * laws[ResistanceLaws::kHysteresis] * row.hysteresis;
  if (all.charge_transfer) {
    const double log_exchange = laws[ResistanceLaws::kLogExchange] - laws[ResistanceLaws::resistance(0)] * row.warm;
    const double share = 0.5 * row.current_a * std::exp(-log_exchange);
    out.taken_v += row.thermal_v * std::asinh(share);
    out.by_log_exchange = row.thermal_v * share / std::sqrt(1.0 + share * share);
    out.by_first_branch = -out.by_log_exchange * row.warm;
  }
  return out;
}

/// What a SOC that is off adds to the OCV, to first order.
double doubted_v(const DoubtedRow& row, const double* doubts, const double* em, LawRow& law) {
  law.doubted = &row;
  law.soc_off = doubts[2 * row.run] + doubts[2 * row.run + 1] * row.from_anchor;
  for (std::size_t k = 0; k < 4; ++k) law.slope_v += row.em_slope[k] * em[k];
  return law.slope_v * law.soc_off;
}

/// What a branch meets in an interval: its time constant within, its resistance at the end, and the currents that it
/// takes.
struct BranchEnd {
  double tau_s, tau_factor, r_ohm, begin_a, end_a;
};
/// Whether derivatives are carried, and below what they count as none.
struct DerivativesOf {
  bool wanted;
  double negligible;
};

/// One interval of a branch.
void step(Branch& branch, const CircuitRow& row, const LawRow& law, const BranchEnd& end,
          const DerivativesOf& derivatives) {
  const double tau_s = end.tau_s, u = end.r_ohm, negligible = derivatives.negligible;
  const IntervalResponse w = interval_response(row.dt_s, tau_s * end.tau_factor);
  if (derivatives.wanted) {
    const double by_tau = w.da * branch.v + w.dg0 * branch.u * end.begin_a + w.dg1 * u * end.end_a;
    branch.open(row.was);
    branch.open(row.middle);
    branch.open(row.at);
    branch.scale(w.a);
    Branch::put(branch.by_r, row.was, w.g0 * end.begin_a);
    Branch::put(branch.by_r, row.at, w.g1 * end.end_a);
    Branch::put(branch.by_tau, row.middle, by_tau * end.tau_factor);
    branch.by_energy = w.a * branch.by_energy + w.g0 * branch.u * end.begin_a * row.warm_was +
                       w.g1 * u * end.end_a * row.warm;
    branch.by_tau_energy = w.a * branch.by_tau_energy + by_tau * tau_s * end.tau_factor * law.tau_warm;
    branch.decay *= w.a;
    if (negligible > 0.0) branch.close(negligible, negligible * 1e-5);
  }
  branch.v = w.a * branch.v + w.g0 * branch.u * end.begin_a + w.g1 * u * end.end_a;
  branch.u = u;
}

/// Goes through all rows; `visit(row, law, error, branches, open_state)` sees those with a weight.
template <class Visit>
void walk(const CircuitRows& all, const CircuitLayout& layout, const double* x, bool derivatives, double negligible,
          const Visit& visit) {
  std::array<Branch, kMostBranches> branches;
  const auto count = static_cast<std::size_t>(layout.branches);
  int open_state = -1;
  for (const CircuitRow& row : all.rows) {
    const double r0_ohm = between(x + layout.r(0), row.at);
    LawRow law = law_row(all, row, x + layout.law(), r0_ohm, count);
    double v = -r0_ohm * law.drop_a - law.taken_v;
    for (std::size_t k = 0; k < 4; ++k) v += row.em_weight[k] * x[row.em_node + static_cast<int>(k)];
    if (!all.in_doubt.empty()) {
      const auto index = static_cast<std::size_t>(&row - all.rows.data());
      v += doubted_v(all.in_doubt[index], x + layout.doubt(), x + row.em_node, law);
    }
    if (row.reset) open_state = row.free_state;
    for (std::size_t k = 0; k < count; ++k) {
      Branch& branch = branches[k];
      const auto index = static_cast<Index>(k);
      const double u = between(x + layout.r(index + 1), row.at);
      if (row.reset) {
        branch.begin(open_state >= 0 ? x[layout.state() + open_state + index] : 0.0, u);
      } else {
        const double tau_s = between(x + layout.tau(index), row.middle);
        const BranchEnd end{tau_s, law.tau_factor[k], u, law.begin_a[k], law.end_a[k]};
        step(branch, row, law, end, {derivatives, negligible});
      }
      v -= branch.v;
    }
    if (row.weight_s > 0.0) visit(row, law, v - row.voltage_v, branches, open_state);
  }
}

/// The non-zero derivatives of one row's voltage, column by column.
struct Line {
  static constexpr std::size_t kMost = 32 + 2 * kMostBranches * (kMostNodes + 1);
  std::array<int, kMost> column;
  std::array<double, kMost> value;
  std::size_t count = 0;

  /// Columns rise: of the sums only one triangle is kept.
  void put(Index at, double derivative) {
    column[count] = static_cast<int>(at);
    value[count++] = derivative;
  }
  void fill(const CircuitRow& row, const LawRow& law, const CircuitLayout& layout,
            const std::array<Branch, kMostBranches>& branches, int open_state, bool with_tau) {
    count = 0;
    for (std::size_t k = 0; k < 4; ++k)
      put(row.em_node + static_cast<Index>(k),
          row.em_weight[k] + (law.doubted != nullptr ? law.soc_off * law.doubted->em_slope[k] : 0.0));
    put(layout.r(0) + row.at.node, -law.drop_a * (1.0 - row.at.fraction));
    put(layout.r(0) + row.at.node + 1, -law.drop_a * row.at.fraction);
    for (Index k = 0; k < layout.branches; ++k) {
      const Branch& branch = branches[static_cast<std::size_t>(k)];
      for (int n = branch.low; n <= branch.high; ++n)
        put(layout.r(k + 1) + n, -branch.by_r[static_cast<std::size_t>(n)]);
    }
    if (with_tau) {
      for (Index k = 0; k < layout.branches; ++k) {
        const Branch& branch = branches[static_cast<std::size_t>(k)];
        for (int n = branch.low; n <= branch.high; ++n)
          put(layout.tau(k) + n, -branch.by_tau[static_cast<std::size_t>(n)]);
      }
    }
    for (Index k = 0; open_state >= 0 && k < layout.branches; ++k)
      put(layout.state() + open_state + k, -branches[static_cast<std::size_t>(k)].decay);
  }
  void add_doubt(const LawRow& law, const CircuitLayout& layout) {
    if (law.doubted == nullptr) return;
    put(layout.doubt() + 2 * law.doubted->run, law.slope_v);
    put(layout.doubt() + 2 * law.doubted->run + 1, law.slope_v * law.doubted->from_anchor);
  }
  /// Of a run that is not all at one temperature, or with a charge transfer or hysteresis.
  void add_laws(const CircuitRow& row, const LawRow& law, const CircuitLayout& layout,
                const std::array<Branch, kMostBranches>& branches, bool with_hysteresis) {
    put(layout.law() + ResistanceLaws::kOhmic, law.by_ohmic);
    for (Index k = 0; k < layout.branches; ++k) {
      const Branch& branch = branches[static_cast<std::size_t>(k)];
      put(layout.law() + ResistanceLaws::resistance(k), (k == 0 ? law.by_first_branch : 0.0) - branch.by_energy);
      put(layout.law() + ResistanceLaws::time_constant(k), -branch.by_tau_energy);
    }
    put(layout.law() + ResistanceLaws::kLogExchange, law.by_log_exchange);
    put(layout.law() + ResistanceLaws::kEntropy, kMillivolt * row.warmer_k);
    put(layout.law() + ResistanceLaws::kHysteresis, with_hysteresis ? -kMillivolt * row.hysteresis : 0.0);
  }
};

/// Rows that follow each other mostly touch the same columns: their products are summed as one small dense matrix,
/// which goes to its places when the columns change.
class Panel {
 public:
  explicit Panel(Index parameters) : parameters_(parameters) {}
  void add(const Line& line, double weight, double error, Eigen::MatrixXd& sums, Eigen::VectorXd& gradient) {
    const bool same =
        line.count == columns_.size() && std::equal(columns_.begin(), columns_.end(), line.column.begin());
    if (!same || filled_ == kRows) flush(sums, gradient);
    if (!same) {
      columns_.assign(line.column.begin(), line.column.begin() + static_cast<std::ptrdiff_t>(line.count));
      VOLTLAP_DEMAND(std::is_sorted(columns_.begin(), columns_.end()));
      lines_.resize(static_cast<Index>(line.count), kRows);
    }
    const double root = std::sqrt(weight);
    lines_.col(filled_) = root * Eigen::Map<const Eigen::VectorXd>(line.value.data(), lines_.rows());
    errors_(filled_++) = root * error;
  }
  void flush(Eigen::MatrixXd& sums, Eigen::VectorXd& gradient) {
    if (filled_ == 0) return;
    const Index count = lines_.rows();
    products_.setZero(count, count);
    products_.selfadjointView<Eigen::Lower>().rankUpdate(lines_.leftCols(filled_));
    const Eigen::VectorXd along = lines_.leftCols(filled_) * errors_.head(filled_);
    for (Index a = 0; a < count; ++a) {
      gradient(columns_[static_cast<std::size_t>(a)]) += along(a);
      double* column = sums.data() + columns_[static_cast<std::size_t>(a)] * parameters_;
      for (Index b = a; b < count; ++b) column[columns_[static_cast<std::size_t>(b)]] += products_(b, a);
    }
    filled_ = 0;
  }

 private:
  static constexpr Index kRows = 64;
  Index parameters_, filled_ = 0;
  std::vector<int> columns_;
  Eigen::MatrixXd lines_, products_;  ///< [column, row]; [column, column]
  Eigen::Matrix<double, kRows, 1> errors_;
};

}  // namespace

CircuitRows::CircuitRows(const std::vector<MeasuredRun>& runs, const SocGrid& ocv, const SocGrid& grid,
                         Index branches, const ResistanceLaws& laws, const std::vector<SocDoubt>& doubts)
    : charge_transfer(laws.has_charge_transfer()), hysteresis(laws.has_hysteresis()) {
  VOLTLAP_DEMAND(doubts.empty() || doubts.size() == runs.size());
  VOLTLAP_DEMAND(branches >= 0 && branches <= kMostBranches && grid.size() <= kMostNodes);
  std::size_t count = 0;
  for (const MeasuredRun& run : runs) count += static_cast<std::size_t>(run.rows());
  rows.reserve(count);
  in_doubt.reserve(doubts.empty() ? 0 : count);
  for (std::size_t r = 0; r < doubts.size(); ++r) {
    for (const double soc : runs[r].soc)
      in_doubt.push_back({ocv.slope_weights(soc).weight, soc - doubts[r].anchor_soc, static_cast<int>(r)});
  }
  for (const MeasuredRun& run : runs) {
    VOLTLAP_DEMAND(run.rows() > 0 && run.soc.size() == run.rows() && run.weight_s.size() == run.rows());
    const double quiet = kQuiet * run.current_a.cwiseAbs().maxCoeff();
    double turned = hysteresis_at_begin(run.soc(0));
    for (Index k = 0; k < run.rows(); ++k) {
      const Index before = std::max<Index>(0, k - 1);
      const SocGrid::Weights em = ocv.weights(run.soc(k));
      if (k > 0 && hysteresis) turned = hysteresis_after(turned, laws.hysteresis_per_soc, run.soc(before) - run.soc(k));
      const double warm_was = laws.inverse(run.temperature_c(before)), warm = laws.inverse(run.temperature_c(k));
      isothermal = isothermal && warm_was == 0.0 && warm == 0.0;
      CircuitRow row{run.dt_s(k),
                     run.current_begin_a(k),
                     run.current_end_a(k),
                     run.current_a(k),
                     warm_was,
                     warm,
                     run.temperature_c(k) - laws.reference_temperature_c,
                     4.0 * kGasConstant * (run.temperature_c(k) + kZeroCelsius) / kFaraday,
                     turned,
                     run.weight_s(k),
                     run.voltage_v(k),
                     place_of(grid, run.soc(before)),
                     place_of(grid, 0.5 * (run.soc(before) + run.soc(k))),
                     place_of(grid, run.soc(k)),
                     static_cast<int>(em.first),
                     em.weight,
                     std::abs(run.current_a(k)) > quiet,
                     run.is_reset(k),
                     -1};
      if (row.reset && !run.at_rest_before[static_cast<std::size_t>(k)]) {
        row.free_state = static_cast<int>(states);
        states += branches;
      }
      if (row.weight_s > 0.0) ++used;
      rows.push_back(row);
    }
  }
}

NormalSums sums_of(const CircuitRows& rows, const CircuitLayout& layout, const double* x, bool with_tau) {
  VOLTLAP_DEMAND(x != nullptr && layout.branches <= kMostBranches && layout.nodes <= kMostNodes);
  VOLTLAP_DEMAND(rows.states == layout.states);
  double most = 0.0;
  for (const CircuitRow& row : rows.rows) most = std::max(most, std::abs(row.current_a));
  constexpr double kNegligible = 1e-5;  // of a derivative, next to its largest
  NormalSums out;
  const Index n = layout.size();
  out.rest = out.load = Eigen::MatrixXd::Zero(n, n);
  out.gradient = Eigen::VectorXd::Zero(n);
  Line line;
  Panel rest(n), load(n);
  const bool with_laws = with_tau && (!rows.isothermal || rows.charge_transfer || rows.hysteresis);
  walk(rows, layout, x, true, kNegligible * most,
       [&](const CircuitRow& row, const LawRow& law, double error, const auto& branches, int open_state) {
         line.fill(row, law, layout, branches, open_state, with_tau);
         if (with_tau) line.add_doubt(law, layout);
         if (with_laws) line.add_laws(row, law, layout, branches, rows.hysteresis);
         const double square = row.weight_s * error * error;
         (row.load ? out.load_square : out.rest_square) += square;
         ++(row.load ? out.load_rows : out.rest_rows);
         (row.load ? load : rest).add(line, row.weight_s, error, row.load ? out.load : out.rest, out.gradient);
       });
  rest.flush(out.rest, out.gradient);
  load.flush(out.load, out.gradient);
  for (Eigen::MatrixXd* sums : {&out.rest, &out.load})
    sums->triangularView<Eigen::StrictlyUpper>() = sums->transpose();
  return out;
}

void residuals_of(const CircuitRows& rows, const CircuitLayout& layout, const double* x, double* residuals,
                  double* derivatives) {
  VOLTLAP_DEMAND(x != nullptr && residuals != nullptr && rows.states == layout.states);
  Line line;
  Index out = 0;
  walk(rows, layout, x, derivatives != nullptr, 0.0,
       [&](const CircuitRow& row, const LawRow& law, double error, const auto& branches, int open_state) {
         const double root = std::sqrt(row.weight_s);
         residuals[out] = root * error;
         if (derivatives != nullptr) {
           line.fill(row, law, layout, branches, open_state, true);
           line.add_doubt(law, layout);
           line.add_laws(row, law, layout, branches, rows.hysteresis);
           for (std::size_t k = 0; k < line.count; ++k)
             derivatives[out * layout.size() + line.column[k]] = root * line.value[k];
         }
         ++out;
       });
}

}  // namespace voltlap::plant
