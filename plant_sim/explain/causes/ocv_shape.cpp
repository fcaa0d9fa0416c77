// SPDX-License-Identifier: Apache-2.0
// The open-circuit voltage over SOC differs in shape: a polygon of three to seven points over the SOC that was
// driven, level beyond its ends, of which the log tells nothing.
#include <algorithm>
#include <cmath>

#include "explain/causes/cause.hpp"
#include "explain/causes/list.hpp"

namespace voltlap::plant {
namespace {

constexpr double kApart = 0.07;  // SOC between points
constexpr double kBend = 0.03;   // V; judgement: what models of real cells miss between two points
constexpr double kLeast = 0.02;  // SOC that has to be driven
constexpr std::size_t kFewest = 3, kMost = 7;
constexpr std::size_t kStored = 201;  // values in the model, from SOC 0 to 1

/// Straight between values at equal steps from `first` to `last`, level beyond.
double polygon(Values values, double first, double last, double soc) {
  const auto steps = static_cast<double>(values.size() - 1);
  const double place = std::clamp((soc - first) / (last - first), 0.0, 1.0) * steps;
  const auto k = std::min(static_cast<std::size_t>(place), values.size() - 2);
  return values[k] + (place - static_cast<double>(k)) * (values[k + 1] - values[k]);
}

/// Adds a polygon between these SOC to the change that the cell has.
void add_polygon(CellEffects& effects, Values values, double first, double last) {
  std::vector<double>& stored = effects.ocv_change_v;
  const std::vector<double> before = stored;
  stored.resize(kStored);
  for (std::size_t i = 0; i < kStored; ++i) {
    const double soc = static_cast<double>(i) / static_cast<double>(kStored - 1);
    stored[i] = (before.empty() ? 0.0 : polygon(before, 0.0, 1.0, soc)) + polygon(values, first, last, soc);
  }
}

}  // namespace

Cause ocv_shape() {
  return {.name = "ocv_shape",
          .balance = Balance::kCharge,
          .says = "the open-circuit voltage differs by {} (RMS) over the SOC that was driven",
          .test = "rests of ten minutes at every tenth of SOC, or a C/20 discharge",
          .parameters = {{"node_1_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_2_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_3_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_4_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_5_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_6_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"},
                         {"node_7_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV"}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            const Eigen::VectorXd soc = driven_soc(model, c);
            double first = soc.minCoeff(), last = soc.maxCoeff();
            // With the true curve the rest tells another SOC; a column that is not judged may be anything.
            if (const Eigen::VectorXd* said = c.log.find("soc"); said != nullptr && c.find("soc") != nullptr) {
              for (const double value : *said) {
                if (!std::isfinite(value)) continue;
                first = std::min(first, value);
                last = std::max(last, value);
              }
            }
            if (!(last - first > kLeast)) return {};
            const auto points =
                std::clamp(static_cast<std::size_t>(std::ceil((last - first) / kApart)) + 2, kFewest, kMost);
            Form form = plain_form(
                kMost, [=](World& w, Values v) { add_polygon(w.car.cell.effects, v.first(points), first, last); });
            form.linear.resize(points);
            form.refined = form.linear;
            form.bend = kBend;
            return with_begun_soc(form, model, c);
          },
          .is_identified = true,
          .reported = {{"rms_v", "V", 1e-4, 0.3, 5e-3, 1e3, "mV"}},
          .report = [](Values v) -> std::vector<double> {
            double square = 0.0, count = 0.0;
            for (const double node : v) {
              square += node * node;
              count += node != 0.0 ? 1.0 : 0.0;
            }
            return {std::sqrt(square / std::max(1.0, count))};
          }};
}

}  // namespace voltlap::plant
