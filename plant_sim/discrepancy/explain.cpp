// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/explain.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/errors.hpp"
#include "discrepancy/causes/list.hpp"
#include "discrepancy/findings.hpp"
#include "discrepancy/further.hpp"
#include "discrepancy/integrity.hpp"
#include "discrepancy/parts.hpp"
#include "discrepancy/saturation.hpp"
#include "discrepancy/steps.hpp"
#include "discrepancy/trust.hpp"
#include "discrepancy/verdict.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t kSetsKept = 400;
constexpr std::size_t kRefined = 5;

/// A log as it is held against the model: with the limit of its current sensor where it has one.
struct Held {
  World world;
  Comparison comparison;
  std::optional<Saturation> saturation;
};

Held held_against(const World& model, const Recording& log, ComparisonOptions compared, const ExplainOptions& options) {
  Held out{model, comparison_of(model, log, compared), {}};
  if (std::count(options.without.begin(), options.without.end(), "current_saturation") > 0) return out;
  out.saturation = saturation_of(model, out.comparison);
  if (!out.saturation) return out;
  out.world.current_limit_a = out.saturation->rail.from_a;
  compared.at_limit = out.saturation->rail.at;
  out.comparison = comparison_of(out.world, log, compared);
  return out;
}

/// Everything about one log that the steps below share.
struct Case {
  std::vector<Cause> causes;
  Design design;
  std::vector<std::unique_ptr<Design>> reference_designs;
  std::vector<Reference> references;
  NoiseModel noise;
  Usual usual;
  std::vector<Candidate> locals;
  Score score;
  System system;
  double usual_evidence = 0.0;  ///< best evidence of a reference against the others
  double usual_of_others = 0.0; ///< the same, but for what acts on the voltage or the charge that all cells share
  std::vector<bool> use;        ///< blocks
};

/// The references' floor, or the log's own.
void learn_floor(Case& c) {
  std::vector<const Design*> designs;
  for (const auto& reference : c.reference_designs) designs.push_back(reference.get());
  if (designs.empty()) designs.push_back(&c.design);
  c.noise = noise_of(designs);
  // A channel that no reference has: its own floor.
  const NoiseModel own = designs.front() == &c.design ? c.noise : noise_of({&c.design});
  for (const auto& [name, noise] : own) c.noise.emplace(name, noise);
  for (const auto& reference : c.reference_designs) {
    NoiseModel theirs = c.noise;
    for (const auto& [name, noise] : noise_of({reference.get()})) theirs.emplace(name, noise);
    c.references.push_back({reference.get(), score_of(*reference, theirs)});
  }
}

void analyse(Case& c, const std::string& fit_blocks) {
  const std::vector<GroupScore> groups = group_scores(c.design, c.noise);
  Score first;
  first.groups = groups;
  // Group spreads are needed to find the local candidates, whose columns the full score then has.
  Usual spreads = group_spread(c.design, first, c.references);
  c.locals = local_candidates(c.design, c.causes, groups, spreads);
  c.score = score_of(c.design, c.noise);
  const Knowledge knowledge = knowledge_of(c.design, c.references);
  std::vector<double> inflation(c.score.channels.size(), 1.0);
  c.usual = usual_discrepancy(c.design, c.score, c.references, knowledge, inflation);
  c.use = blocks_used(fit_blocks, c.score.blocks());
  c.system = system_of(c.design, c.locals, c.score, c.usual, c.causes, c.use);
  if (c.references.size() < 2) return;
  const std::vector<BlockSum> said = channel_totals(c.score);
  const TrustProblem problem{c.design, said, knowledge, c.system};
  inflation = inflation_by_references(problem, c.usual);
  c.usual = usual_discrepancy(c.design, c.score, c.references, knowledge, inflation);
  c.system = system_of(c.design, c.locals, c.score, c.usual, c.causes, c.use);
  c.system.bounds = bounds_of(said, knowledge);
  c.usual_evidence = evidence_of_references(problem, c.usual, inflation);
  c.usual_of_others = evidence_of_references(problem, c.usual, inflation, -1, Asked::kNotOfAllCells);
}

/// Sets by their evidence in `weighed`, which is tempered by what sound logs show of such sets.
std::vector<WeighedSet> weigh(const Case& c, double signature_error, System& weighed) {
  weighed = tempered(c.system, c.usual_evidence, signature_error);
  std::vector<WeighedSet> sets = weigh_sets(weighed, kSetsKept);
  // What references show of the cells' voltage says nothing of a contact, a thermistor or one cell.
  if (sets.empty() || is_of_all_cells(c.system, sets[0].members) || !(c.usual_of_others < c.usual_evidence)) return sets;
  System others = tempered(c.system, c.usual_of_others, signature_error);
  std::vector<WeighedSet> again = weigh_sets(others, kSetsKept);
  if (again.empty() || is_of_all_cells(c.system, again[0].members)) return sets;
  weighed = std::move(others);
  return again;
}

/// Nonlinear fits of the best sets may change their order, or leave the log.
void refine_best(const Case& c, std::vector<WeighedSet>& sets, const Refinery& refinery, double tempering) {
  const double best = sets.empty() ? 0.0 : sets[0].evidence;
  std::size_t refined = 0;
  for (std::size_t k = 0; k < sets.size() && refined < kRefined; ++k) {
    if (best <= 0.0 || best - sets[k].evidence > 4.0 * kDecisive) break;
    if (!sets[k].named) continue;
    const RefinedSet set = refinery.refine(sets[k].members);
    const double gained = set.gain - fit_set(c.system, sets[k].members).gain;
    // Signatures are straight lines; what bends may fit better. A size beyond its prior fits worse where it ends.
    const bool ends = std::any_of(set.causes.begin(), set.causes.end(),
                                  [](const RefinedCause& fit) { return !fit.inside_prior; });
    sets[k].evidence += 0.5 * tempering * (ends ? gained : std::max(0.0, gained));
    if (!has_room(c.design, c.references, c.noise, set.world)) sets[k].evidence = 0.0;
    ++refined;
  }
  std::stable_sort(sets.begin(), sets.end(),
                   [](const WeighedSet& a, const WeighedSet& b) { return a.evidence > b.evidence; });
}

}  // namespace

const char* name_of(Verdict verdict) {
  constexpr const char* kNames[] = {"named", "ambiguous", "unknown", "no_discrepancy", "bad_data"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Explanation explain(const Model& model, const Recording& raw, const ExplainOptions& options) {
  const auto progress = [&](const std::string& what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  Explanation out;
  out.with_references = !options.references.empty();
  ComparisonOptions compared{model.kind != ModelKind::kCell, out.with_references};
  Gated gated = integrity_gate(raw, model);
  std::vector<std::vector<GateFinding>> usual_findings;
  bool limit_is_usual = false;
  Case c;
  c.causes = catalogue(options.without);
  size_for(model.world.car.cell, c.causes);
  for (const Recording& reference : options.references) {
    Gated theirs = integrity_gate(reference, model);
    usual_findings.push_back(theirs.findings);
    Held held = held_against(model.world, theirs.log, compared, options);
    limit_is_usual = limit_is_usual || held.saturation;
    c.reference_designs.push_back(std::make_unique<Design>(design_of(held.world, std::move(held.comparison), c.causes)));
    // One logger holds the current in one way; a log with an effect in it could seem to hold it otherwise.
    compared.hold = c.reference_designs.front()->comparison.facts.hold;
    progress("reading references", static_cast<double>(c.reference_designs.size()) /
                                       static_cast<double>(options.references.size()));
  }
  out.masked = gated.log.masked;
  out.notes = gated.log.repairs;
  std::vector<FoundCause> gate = unusual_findings(gated.findings, usual_findings);
  if (!gated.enough.empty()) {
    out.verdict = Verdict::kBadData;
    out.causes = gate;
    out.sentence = gated.enough;
    out.next_test = gated.drive;
    return out;
  }
  progress("comparing with the model", 0.2);
  Held log = held_against(model.world, gated.log, compared, options);
  if (log.saturation) {
    mask_rail(*log.saturation, gated.log, out.masked);
    if (!limit_is_usual) gate.insert(gate.begin(), found_saturation(*log.saturation));
  }
  c.design = design_of(log.world, std::move(log.comparison), c.causes);
  learn_floor(c);
  allow_for_steps(coarser_by_a(gated.findings, usual_findings), c.causes, c.design, c.noise);
  progress("weighing causes", 0.5);
  analyse(c, options.fit_blocks);
  // Share rho of a signature's energy that is not believed: 6 % decide at ln 20, however large an effect is. Without
  // references the floor is wide, and 2 % do.
  constexpr double kSignatureError = 0.01, kAlone = 0.003;
  const double signature_error = c.references.empty() ? kAlone : kSignatureError;
  System weighed;
  std::vector<WeighedSet> sets = weigh(c, signature_error, weighed);
  const Refinery refinery(c.design, c.causes, c.system, c.noise, c.usual, rows_of_blocks(c.design, c.use));
  progress("refining", 0.7);
  refine_best(c, sets, refinery, weighed.score.norm() / c.system.score.norm());
  progress("null distribution", 0.85);
  const Decision decision = decide(weighed, sets, options.draws, options.seed);
  const Parts parts = parts_of(c.design, c.locals, c.score, c.usual, c.causes, c.use);
  std::optional<Comparison> holdout;
  if (options.holdout) {
    holdout = held_against(model.world, integrity_gate(*options.holdout, model).log, compared, options).comparison;
  }
  const auto say = [&](const Decision& decided) {
    Explanation said = out;
    put_verdict({c.causes, c.design, c.locals, c.system, c.noise, c.usual, c.use, sets, decided, parts, refinery,
                 holdout ? &*holdout : nullptr}, c.references, gate, said);
    return said;
  };
  const Beside beside{c.system, c.score, c.usual.inflation, c.usual_evidence, signature_error};
  const std::optional<Decision> further = with_further_causes(beside, decision);
  std::optional<Explanation> more;
  if (further) more = say(*further);
  // Causes beside the answer are said when nothing speaks against them, or not at all.
  out = more && more->verdict == Verdict::kNamed ? *more : say(decision);
  note_larger_than_references(c.design, c.references, out);
  if (log.saturation) {
    put_readings_before(model.world, c.design, holdout ? *holdout : c.design.comparison, out);
    if (!limit_is_usual) say_first(gate.front().says, out.sentence);
  }
  return out;
}

}  // namespace voltlap::plant
