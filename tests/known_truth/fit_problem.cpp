// SPDX-License-Identifier: Apache-2.0
// One least squares problem of the full fit, written down so that another program can solve it too, and this project's
// own solution with its time. Part of ./voltlap benchmark-fit.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <nlohmann/json.hpp>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/guarded_main.hpp"
#include "comparison.hpp"
#include "core/parameter_file.hpp"
#include "io/atomic_file.hpp"
#include "learn/bench/plan_file.hpp"
#include "learn/identify/fit/full_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace {

using namespace voltlap::plant;
using Json = nlohmann::json;

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Vector>
std::vector<double> list(const Vector& v) {
  return {v.data(), v.data() + v.size()};
}

struct Timed {
  double seconds = 1e300;
  RefineResult result;
};

/// Through all costs in turn, each from where the one before ended; the quickest of a few.
Timed solved(const std::vector<const CircuitResiduals*>& costs, const Eigen::VectorXd& start) {
  constexpr int kTimes = 5;
  constexpr double kTolerance = 1e-8;  // as the rival's
  Timed out;
  for (int k = 0; k < kTimes; ++k) {
    const double begin = processor_s();
    RefineResult result{start};
    int iterations = 0;
    for (const CircuitResiduals* cost : costs) {
      result = refine(*cost, result.p, 60, kTolerance);
      iterations += result.iterations;
    }
    out.seconds = std::min(out.seconds, processor_s() - begin);
    out.result = result;
    out.result.iterations = iterations;
  }
  return out;
}

Json json_of(const Timed& timed) {
  return {{"p", list(timed.result.p)}, {"seconds", timed.seconds}, {"iterations", timed.result.iterations}};
}

/// Four hours at 1 Hz.
CellLog recording() {
  const DataFolder data(VOLTLAP_DATA_FOLDER);
  const BenchPlan plan = load_plan(data, "pulse_15",
                                   {"test.temperature_c=30", "test.current_a=200", "instruments.systematic=false",
                                    "box.mode=bath", "rest.rule=fixed", "rest.seconds=780"});
  const Campaign campaign(plan, load_cell(data, "aesc_e5_2p", "benchmark"), 1);
  return voltlap::known_truth::log_of(campaign.run(0), 0);
}

Json problem() {
  const CellLog log = recording();
  IdentifyOptions options;
  options.branches = 2;
  options.reference_temperature_c = 30.0;
  options.hold = CurrentHold::kLinear;
  const double begin = processor_s();
  const IdentifyResult whole = identify({log}, options);
  const double whole_s = processor_s() - begin;

  std::vector<std::string> notes;
  const std::vector<CellLog> logs{log};
  std::vector<PreparedLog> prepared = prepare(logs, {{}, {}, {30.0}, options.hold}, notes);
  std::vector<MeasuredRun> means = runs_of(prepared);
  FitPriors priors;
  priors.resistance_scale = 1.2e-3;
  priors.laws.reference_temperature_c = 30.0;
  const FullFit full = full_fit(means, priors, {2, {}, 3e-7, {}, {}}, notes);
  const std::vector<MeasuredRun> rows = runs_of(prepared, true);
  const CircuitFit fit(rows, 2, full.priors);
  const CircuitResiduals cost(fit, full.tau_centre_s);
  const Eigen::MatrixXd taus = full.tau_centre_s.transpose().replicate(fit.r_count(), 1);
  const Eigen::VectorXd start = cost.pack(fit.solve(taus), taus);
  // As identify sees the recording: steady rows averaged.
  const CircuitFit coarse_fit(means, 2, full.priors);
  const CircuitResiduals coarse(coarse_fit, full.tau_centre_s);
  const MeasuredRun& run = rows.front();
  return {{"rows", run.rows()},
          {"hours", (run.time_s(run.rows() - 1) - run.time_s(0)) / 3600.0},
          {"identify_s", whole_s},
          {"identify_rms_v", whole.rms_v},
          {"dt_s", list(run.dt_s)},
          {"begin_a", list(run.current_begin_a)},
          {"end_a", list(run.current_end_a)},
          {"current_a", list(run.current_a)},
          {"voltage_v", list(run.voltage_v)},
          {"soc", list(run.soc)},
          {"weight_s", list(run.weight_s)},
          {"ocv_soc", fit.ocv().nodes()},
          {"soc_nodes", fit.grid().nodes()},
          {"roughness_weights", list(full.priors.roughness_weights)},
          {"log_tau_weight", std::sqrt(full.priors.noise_v2_s) / full.priors.log_tau_sigma},
          {"log_tau_centre", list(Eigen::VectorXd(full.tau_centre_s.array().log()))},
          {"start", list(start)},
          {"averaged", json_of(solved({&coarse}, start))},
          {"all_rows", json_of(solved({&cost}, start))},
          {"both", json_of(solved({&coarse, &cost}, start))}};
}

int run(int argc, char** argv) {
  CLI::App app("Writes a least squares problem of the full fit, and solves it.", "voltlap-fit-problem");
  std::string path;
  add_output_file(app, "--json", path, "Where to write it");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitInput;
  }
  AtomicFile file(path);
  file.write(problem().dump());
  file.commit();
  return kExitOk;
}

}  // namespace

int main(int argc, char** argv) { return voltlap::plant::guarded_main(run, argc, argv); }
