// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/identify_by_stage.hpp"

#include <chrono>
#include <cmath>
#include <limits>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "learn/identify/fit/recording_result.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

/// Stage by stage the same for each recording; their mean, and the sections of all.
StageFit mean_fit(const std::vector<PreparedLog>& prepared, Method method) {
  VOLTLAP_DEMAND(!prepared.empty());
  StageFit mean;
  for (const PreparedLog& one : prepared) {
    const MeasuredRun whole = make_run(*one.log, one.run);
    StageFit fit = stage_fit(whole, thinned(whole, kRestThinning), method);
    mean.sections.insert(mean.sections.end(), fit.sections.begin(), fit.sections.end());
    mean.iterations += fit.iterations;
    if (mean.model.em.size() == 0) {
      mean.model = std::move(fit.model);
    } else {
      mean.model.em += fit.model.em;
      mean.model.r += fit.model.r;
      mean.model.tau += fit.model.tau;
    }
  }
  const double share = 1.0 / static_cast<double>(prepared.size());
  mean.model.em *= share;
  mean.model.r *= share;
  mean.model.tau *= share;
  return mean;
}

void refuse_other_options(const IdentifyOptions& options) {
  if (options.block_s <= 0.0 && options.ocv.empty()) return;
  throw InputError("--method", name_of(*options.method),
                   "no --blocks and no --ocv: the pulse and layered methods take whole pulses and the OCV of their "
                   "rests",
                   "Leave them out, or leave out --method");
}

void require_full_charges(const std::vector<PreparedLog>& prepared) {
  for (const PreparedLog& one : prepared) {
    if (!one.anchored) {
      throw InputError(one.log->path, "no full charge in it", "a pulse test that begins or ends a full charge",
                       "Leave out --method: the full fit finds its SOC from the other recordings");
    }
  }
}

/// How the model, as it is written, follows whole recordings.
void score_recordings(const std::vector<PreparedLog>& prepared, IdentifyResult& result) {
  VOLTLAP_DEMAND(result.model.em.size() == result.model.ocv.size());
  double square = 0.0, weight = 0.0, floor = 0.0;
  for (const PreparedLog& one : prepared) {
    const MeasuredRun whole = make_run(*one.log, one.run);
    const Eigen::VectorXd error = simulate(result.model, whole) - whole.voltage_v;
    square += whole.weight_s.dot(error.cwiseAbs2());
    weight += whole.weight_s.sum();
    floor += noise_floor(whole) * whole.weight_s.sum();
    result.files.push_back(recording_result(one, whole, error));
  }
  result.rms_v = std::sqrt(square / weight);
  result.noise_floor_v2 = floor / weight;
}

}  // namespace

CircuitModel initial_pulse_model(const std::vector<PreparedLog>& prepared) {
  return mean_fit(prepared, Method::kInitialPulse).model;
}

IdentifyResult identify_by_stage(const std::vector<CellLog>& logs, const IdentifyOptions& options) {
  VOLTLAP_DEMAND(!logs.empty() && options.method.has_value());
  const auto begin = std::chrono::steady_clock::now();
  refuse_other_options(options);
  IdentifyResult result;
  const std::vector<PreparedLog> prepared = prepare(
      logs,
      {options.capacity_ah, options.capacity_fallback_ah, options.temperatures_c, options.hold, options.ocv},
      result.notes);
  result.capacity = prepared.front().capacity;
  require_full_charges(prepared);
  if (options.progress) options.progress(name_of(*options.method));
  StageFit fit = mean_fit(prepared, *options.method);
  result.model = std::move(fit.model);
  result.model.capacity_ah = prepared.front().run.capacity_ah;
  result.model.laws = assumed_laws(options.reference_temperature_c);
  result.sections = std::move(fit.sections);
  result.iterations = fit.iterations;
  const Index parameters = result.model.em.size() + result.model.r.size() + result.model.tau.size();
  const Eigen::VectorXd none = Eigen::VectorXd::Constant(parameters, std::numeric_limits<double>::quiet_NaN());
  result.uncertainty = {none, none};
  result.notes.push_back(std::string("Method ") + name_of(*options.method) +
                         ": no smoothness, no choice of order, no intervals.");
  score_recordings(prepared, result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace voltlap::plant
