// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/full_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/demand.hpp"
#include "core/parameters.hpp"
#include "core/signal.hpp"
#include "learn/identify/fit/evidence.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr int kSearchEvaluations = 30;
constexpr double kTogether = 0.3;  // of ln(tau) over SOC, around the centre that several tests have together

/// Rows that no fit explains: contactors that open, glitches. They are given no weight, and counted.
std::size_t drop_outliers(std::vector<MeasuredRun>& runs, const std::vector<Eigen::VectorXd>& errors) {
  constexpr double kLeast = 0.05, kTimes = 10.0;  // V; times the typical error
  constexpr double kSigmaOfMedian = 1.4826;       // of the sizes of normal errors
  VOLTLAP_DEMAND(errors.size() == runs.size());
  std::vector<double> sizes;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Index row = 0; row < runs[k].rows(); ++row) {
      if (runs[k].weight_s(row) > 0.0) sizes.push_back(std::abs(errors[k](row)));
    }
  }
  const double limit = std::max(kLeast, kTimes * kSigmaOfMedian * median(std::move(sizes)));
  std::size_t dropped = 0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Index row = 0; row < runs[k].rows(); ++row) {
      if (runs[k].weight_s(row) > 0.0 && std::abs(errors[k](row)) > limit) {
        runs[k].weight_s(row) = 0.0;
        ++dropped;
      }
    }
  }
  return dropped;
}

/// Whether the current under load has rates that differ: by half in one recording. Between recordings less counts:
/// what a little more current does would else be an energy, and a sure one where they are a few kelvin apart.
bool has_several_rates(const std::vector<MeasuredRun>& runs) {
  constexpr double kLoad = 0.05, kInOne = 1.5, kBetween = 1.05;  // of the largest; ratios
  constexpr double kFewestSeconds = 5.0;
  double most = 0.0;
  for (const MeasuredRun& run : runs) most = std::max(most, run.current_a.cwiseAbs().maxCoeff());
  std::vector<std::pair<double, double>> rates;  // |I|, seconds
  for (const MeasuredRun& run : runs) {
    for (Index row = 0; row < run.rows(); ++row) {
      const double rate = std::abs(run.current_a(row));
      if (rate > kLoad * most && run.weight_s(row) > 0.0) rates.emplace_back(rate, run.weight_s(row));
    }
  }
  std::sort(rates.begin(), rates.end());
  double seconds = 0.0;
  const auto reached = [&](const auto& from, const auto& to) {
    seconds = 0.0;
    for (auto at = from; at != to; ++at) {
      seconds += at->second;
      if (seconds >= kFewestSeconds) return at->first;
    }
    return 0.0;
  };
  const double low = reached(rates.begin(), rates.end()), high = reached(rates.rbegin(), rates.rend());
  return low > 0.0 && high > (runs.size() > 1 ? kBetween : kInOne) * low;
}

/// One recording, one course of decisions.
class FullFitter {
 public:
  FullFitter(std::vector<MeasuredRun>& runs, FitPriors priors, const FullFitOptions& options,
             std::vector<std::string>& notes)
      : runs_(runs), priors_(std::move(priors)), options_(options), notes_(notes) {}

  FullFit run() {
    say("time constants");
    branches_ = options_.branches > 0 ? options_.branches : 2;
    priors_.smoothness = 1.0;
    coarse_ = coarsened_where_many(runs_);
    begin();
    // A step that fails decides nothing: the next way begins afresh.
    bool settled = !priors_.constant && by_evidence();
    if (settled && choose_order(2)) settled = by_evidence();  // what two leave is noise: one may be enough
    if (!settled && options_.one_temperature) begin_with_held_laws();
    if (!settled) by_prediction();
    out_.tau_centre_s = taus_;
    VOLTLAP_DEMAND(out_.packed.size() == out_.uncertainty.sigma.size() && out_.fit.states.size() == runs_.size());
    return std::move(out_);
  }

 private:
  void say(const char* what) const {
    if (options_.progress) options_.progress(what);
  }
  /// Time constants, laws and noise; rows that no circuit follows lose their weight.
  void begin() {
    search(first_taus(branches_));
    settle_laws();
    auto errors = errors_of(linear_fit(runs_, taus_, priors_), runs_);
    if (const std::size_t dropped = drop_outliers(runs_, errors); dropped > 0) {
      notes_.push_back(fmt::format("{} rows that no circuit follows are not used.", dropped));
      coarse_ = coarsened_where_many(runs_);
      settle_laws();
      errors = errors_of(linear_fit(runs_, taus_, priors_), runs_);
    }
    priors_.noise_v2_s = noise_density(runs_, errors);
  }
  void begin_with_held_laws() {
    law_priors_given_ = priors_.law_priors;
    priors_.law_priors.hold_temperature();
    ResistanceLaws::Packed laws = priors_.law_priors.mean;
    laws(ResistanceLaws::kHysteresis) = priors_.laws.hysteresis_mv;
    priors_.laws.exchange_a = 0.0;
    priors_.laws.take(laws);
    out_.laws_held = true;
    begin();
  }
  void search(const Eigen::VectorXd& from) {
    if (options_.tau_centre_s) {
      VOLTLAP_DEMAND(options_.tau_centre_s->size() == branches_);
      taus_ = *options_.tau_centre_s;
      priors_.log_tau_sigma = kTogether;
    } else {
      taus_ = CircuitFit(coarse_, branches_, priors_).search_taus(from, kSearchEvaluations);
    }
  }
  [[nodiscard]] Eigen::VectorXd packed_start(const CircuitResiduals& cost) const {
    if (options_.start && options_.start->branches() == branches_) {
      LinearSolution given{Eigen::VectorXd::Zero(cost.fit().linear_count())};
      given.x.head(options_.start->em.size()) = options_.start->em;
      given.x.segment(options_.start->em.size(), options_.start->r.size()) = options_.start->r.reshaped();
      return cost.pack(given, options_.start->tau);
    }
    const Eigen::MatrixXd taus = taus_.transpose().replicate(cost.fit().r_count(), 1);
    return cost.pack(cost.fit().solve(taus), taus);
  }
  /// A fit of tables with laws. Over temperatures that are far apart branches may take each other's place: a fast one
  /// that slows down much in the cold beside a slow one that does not. From energies that are all alike a fit may end
  /// with each the other's; the best of three is taken. It needs time constants that a fit has settled.
  [[nodiscard]] TableFit fit_from_several_energies() const {
    constexpr double kApart = 30.0;  // kJ/mol of the first and of the last branch from what is believed
    TableFit best = table_fit(coarse_, taus_, priors_);
    if (runs_.size() < 2 || branches_ < 2) return best;
    const ResistanceLaws believed = assumed_laws(priors_.laws.reference_temperature_c);
    for (const double apart : {kApart, -kApart}) {
      CircuitModel from = best.fit.model;
      for (Index k = 0; k < branches_; ++k) {
        const double place = 1.0 - 2.0 * static_cast<double>(k) / static_cast<double>(branches_ - 1);
        ResistanceLaws::BranchEnergies& of = from.laws.branch_kj_per_mol[static_cast<std::size_t>(k)];
        of = believed.branch_kj_per_mol[static_cast<std::size_t>(k)];
        of.time_constant += apart * place;
      }
      TableFit other = table_fit(coarse_, taus_, priors_, &from);
      if (other.cost < best.cost) best = std::move(other);
    }
    return best;
  }
  /// The laws, where the recordings have more than one temperature or rate. With several rates a charge transfer that
  /// bends R0 over the current is among them: in one recording, or at one temperature, if that is decisively better, in
  /// several unless it is decisively worse. Without it the energies of tests that differ in both would hold what the
  /// current does, and be sure of it.
  void settle_laws() {
    if (priors_.law_priors.fixed) return;
    constexpr double kDecisive = 6.0;  // of the noise density: twice ln 20
    constexpr double kHardlyAny = 10.0;  // times the exchange current that is believed
    // What a cell's own warmth takes of what is left, at least, to be a law: errors of a circuit take a tenth (the Leaf
    // at most 9 %, drawn cells 7 %), laws of drawn cells 31 and 89 %.
    constexpr double kOfACircuit = 0.8;
    say("laws over temperature and current");
    // Twice: before there are laws, what is left is far from noise, and what is believed beforehand counts too much.
    TableFit plain = table_fit(coarse_, taus_, priors_);
    for (int pass = 0; pass < 2; ++pass) {
      priors_.laws = plain.fit.model.laws;
      search(taus_);
      priors_.noise_v2_s = noise_density(coarse_, errors_of(linear_fit(coarse_, taus_, priors_), coarse_));
      plain = fit_from_several_energies();
    }
    priors_.laws = plain.fit.model.laws;
    left_v2_s_ = noise_density(coarse_, errors_of(plain.fit, coarse_));
    if (!has_several_rates(runs_)) return;
    FitPriors bent = priors_;
    bent.laws.exchange_a = std::exp(bent.law_priors.mean(ResistanceLaws::kLogExchange));
    TableFit with = table_fit(coarse_, taus_, bent);
    const double decisive = kDecisive * priors_.noise_v2_s;
    if (with.cost >= plain.cost) {
      // From what is believed a fit may end far off. From the plain one, with a charge transfer that takes next to
      // nothing, it can become better only.
      CircuitModel from = plain.fit.model;
      from.laws.exchange_a = kHardlyAny * bent.laws.exchange_a;
      TableFit again = table_fit(coarse_, taus_, bent, &from);
      if (again.cost < with.cost) with = std::move(again);
    }
    if (out_.laws_held) {
      // A cell that is warmer at the higher rate has less resistance there: of one temperature a bend over the current
      // is told only where no energy does as well.
      FitPriors free = priors_;
      free.law_priors = law_priors_given_;
      const TableFit warmed = table_fit(coarse_, taus_, free);
      const double held = std::min(plain.cost, with.cost);
      if (warmed.cost < std::min(held - decisive, kOfACircuit * held)) {
        out_.laws_held = false;
        priors_ = free;
        with = warmed;
      } else if (with.cost >= warmed.cost - decisive) {
        return;
      }
    } else if (with.cost >= plain.cost + (runs_.size() > 1 ? decisive : -decisive)) {
      return;
    }
    priors_.laws = with.fit.model.laws;
    left_v2_s_ = noise_density(coarse_, errors_of(with.fit, coarse_));
  }
  void take(const CircuitResiduals& cost, const Eigen::VectorXd& packed) {
    out_.packed = packed;
    out_.fit.model = cost.model_of(packed);
    out_.fit.states = states_by_run(runs_, cost.states_of(packed), branches_);
  }
  /// True when another number of branches than before is better.
  bool choose_order(Index most) {
    if (options_.branches > 0) return false;
    say("number of RC branches");
    out_.orders = score_orders(coarse_, priors_, most);
    const Index chosen = best_order(out_.orders);
    if (chosen == branches_) return false;
    branches_ = chosen;
    search(first_taus(branches_));
    return true;
  }

  /// What tables over SOC leave of the coarse recordings is so much more than noise that no smoothing makes it noise.
  [[nodiscard]] bool is_far_from_noise() const {
    constexpr double kFar = 10.0, kLeast = 0.03;  // of the instrument's noise, as a power density; V s^0.5
    return left_v2_s_ > std::max(kLeast * kLeast, kFar * kFar * options_.instrument_v2_s);
  }

  /// False when the residual is no noise.
  bool by_evidence() {
    constexpr double kFree = 2.0;  // of ln(tau): the search's single value for all SOC says little
    if (is_far_from_noise()) return false;
    say("smoothness by evidence");
    FitPriors priors = priors_;
    if (!options_.tau_centre_s) priors.log_tau_sigma = kFree;
    const CircuitFit first(runs_, branches_, priors);
    EvidenceFit fit = fit_by_evidence(runs_, branches_, priors, taus_, packed_start(CircuitResiduals(first, taus_)));
    const auto settle = [&] {
      const CircuitFit circuit(runs_, branches_, fit.priors);
      take(CircuitResiduals(circuit, taus_), fit.fit.p);
      return colour_of(runs_, errors_of(out_.fit, runs_), options_.instrument_v2_s);
    };
    ResidualColour colour = settle();
    if (!colour.is_noise) return false;
    if (colour.ratio > 1.0) {
      fit = fit_by_evidence(runs_, branches_, fit.priors, taus_, fit.fit.p, colour.ratio);
      colour = settle();
    }
    const CircuitFit circuit(runs_, branches_, fit.priors);
    out_.uncertainty = uncertainty_of_noise(CircuitResiduals(circuit, taus_), fit.fit.p, colour.ratio);
    out_.priors = fit.priors;
    out_.smoothness_from = "evidence";
    out_.noise_v2_s = fit.priors.noise_v2_s;
    out_.iterations = fit.fit.iterations;
    return true;
  }

  /// Of the branches that were chosen as many as leave noise alone, by evidence. False when all do not.
  bool fewest_that_leave_noise(FitPriors own) {
    const Index chosen = branches_;
    std::swap(priors_, own);
    for (branches_ = 3; branches_ <= chosen; ++branches_) {
      search(first_taus(branches_));
      if (!by_evidence()) continue;
      out_.smoothness_scores.clear();
      return true;
    }
    branches_ = chosen;
    std::swap(priors_, own);
    return false;
  }

  /// One value for all SOC where tables do not predict better what was kept back.
  void choose_plain() {
    if (priors_.constant || options_.tau_centre_s || options_.start) return;
    say("a plain circuit beside tables over SOC");
    const PlainScore score = score_plain(coarse_, taus_, priors_);
    constexpr double kMillivolt = 1e3;
    notes_.push_back(fmt::format("What was kept back is predicted within {:.1f} mV by a plain circuit, within {:.1f} "
                                 "mV by tables over SOC: {}.",
                                 kMillivolt * score.plain_v, kMillivolt * score.tables_v,
                                 score.is_enough ? "one value of each resistance and time constant for all SOC"
                                                 : "tables"));
    if (!score.is_enough) return;
    priors_.constant = true;
    search(taus_);
  }

  void by_prediction() {
    FitPriors own = priors_;
    priors_.ocv.insert(priors_.ocv.end(), options_.rests.begin(), options_.rests.end());
    say("smoothness by prediction");
    if (!priors_.constant) priors_.em_roughness_v = choose_ocv_roughness(coarse_, taus_, priors_);
    choose_plain();
    priors_.smoothness = choose_smoothness(coarse_, taus_, priors_, out_.smoothness_scores);
    if (choose_order(static_cast<Index>(kMostCellBranches)) && branches_ > 2 && !priors_.constant) {
      if (fewest_that_leave_noise(std::move(own))) return;
    }
    search(taus_);
    say("full fit");
    // Twice: how much prior knowledge counts depends on the noise, which only a full fit shows.
    std::optional<CircuitFit> circuit;
    std::optional<CircuitResiduals> cost;
    for (int pass = 0; pass < 2; ++pass) {
      circuit.emplace(runs_, branches_, priors_);
      cost.emplace(*circuit, taus_);
      const RefineResult refined = refine(*cost, pass == 0 ? packed_start(*cost) : out_.packed);
      out_.iterations += refined.iterations;
      take(*cost, refined.p);
      priors_.noise_v2_s = noise_density(runs_, errors_of(out_.fit, runs_));
    }
    out_.uncertainty = uncertainty_of(*cost, out_.packed, lasting_density(runs_, errors_of(out_.fit, runs_)));
    out_.priors = priors_;
    const bool chosen = !out_.smoothness_scores.empty();
    out_.smoothness_from = chosen ? "held-out pulses" : "--constant";
    out_.smoothness = chosen ? priors_.smoothness : 0.0;
    out_.noise_v2_s = priors_.noise_v2_s;
  }

  std::vector<MeasuredRun>& runs_;
  std::vector<MeasuredRun> coarse_;  ///< the same in fewer rows
  FitPriors priors_;
  const FullFitOptions& options_;
  std::vector<std::string>& notes_;
  Index branches_ = 2;
  Eigen::VectorXd taus_;
  LawPriors law_priors_given_;  ///< before those over the temperature were held
  double left_v2_s_ = 0.0;  ///< density of what tables with laws leave, where these were settled
  FullFit out_;
};

/// Says where time constants stopped at what the recordings can tell: their longest rest or load, their shortest step.
void note_bounds(const FullFit& full, std::vector<std::string>& notes) {
  constexpr double kAtBound = 1e-4;
  const Eigen::MatrixXd& tau = full.fit.model.tau;
  for (Index k = 0; k < tau.cols(); ++k) {
    for (const double bound_s : {full.priors.tau_shortest_s, full.priors.tau_bound_s}) {
      const auto count = ((tau.col(k).array() / bound_s - 1.0).abs() < kAtBound).count();
      if (count == 0) continue;
      notes.push_back(fmt::format(
          "tau{} stands at its bound of {:.4g} s at {} of {} nodes: the recordings tell no {} one.", k + 1, bound_s,
          count, tau.rows(), bound_s == full.priors.tau_bound_s ? "longer" : "shorter"));
    }
  }
}

}  // namespace

FullFit full_fit(std::vector<MeasuredRun>& runs, FitPriors priors, const FullFitOptions& options,
                 std::vector<std::string>& notes) {
  VOLTLAP_DEMAND(!runs.empty() && options.branches >= 0 && options.instrument_v2_s > 0.0);
  FullFit out = FullFitter(runs, priors, options, notes).run();
  note_bounds(out, notes);
  if (!options.ends_undriven || out.priors.constant) return out;
  if (options.progress) options.progress("a plain circuit, for the charge that nothing passed");
  FullFitOptions beside = options;
  beside.progress = nullptr;
  beside.branches = static_cast<int>(out.fit.model.branches());
  beside.start.reset();
  priors.constant = true;
  std::vector<MeasuredRun> same = runs;
  std::vector<std::string> unsaid;
  out.plain = FullFitter(same, std::move(priors), beside, unsaid).run().fit.model;
  return out;
}

}  // namespace voltlap::plant
