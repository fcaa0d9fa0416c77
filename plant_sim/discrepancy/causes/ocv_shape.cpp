// SPDX-License-Identifier: Apache-2.0
// The open-circuit voltage over SOC differs in shape; a polygon of seven points, its ends included.
#include <algorithm>
#include <cmath>

#include "discrepancy/cause.hpp"
#include "discrepancy/causes/list.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRepeats = 1e-3;  // V: what sound logs of the bank's cars show of it, where references were fuller

}  // namespace

Cause ocv_shape() {
  return {.name = "ocv_shape",
          .balance = Balance::kCharge,
          .says = "the open-circuit voltage differs by {} (RMS) over the SOC that was driven",
          .test = "rests of ten minutes at every tenth of SOC, or a C/20 discharge",
          .parameters =
              {{"node_1_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_2_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_3_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_4_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_5_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_6_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats},
               {"node_7_v", "V", -0.3, 0.3, 5e-3, 1e3, "mV", kRepeats}},
          .forms = [](const World& model, const Comparison& c) -> std::vector<Form> {
            Form form = plain_form(7, [](World& w, Values v) {
              std::vector<double>& nodes = w.car.cell.effects.ocv_change_v;
              if (nodes.empty()) nodes.assign(v.size(), 0.0);
              for (std::size_t k = 0; k < v.size(); ++k) nodes[k] += v[k];
            });
            const Eigen::VectorXd soc = predict(model, c).battery.soc;
            form.linear.clear();
            for (std::size_t k = 0; k < 7; ++k) {
              const double node = static_cast<double>(k) / 6.0;
              if (node > soc.minCoeff() - 0.16 && node < soc.maxCoeff() + 0.16) form.linear.push_back(k);
            }
            form.refined = form.linear;
            if (form.linear.size() < 3) return {};
            return {form};
          },
          .reported = {{"rms_v", "V", 1e-4, 0.3, 5e-3, 1e3, "mV"}},
          .report =
              [](Values v) -> std::vector<double> {
            double square = 0.0, count = 0.0;
            for (const double node : v) {
              square += node * node;
              count += node != 0.0 ? 1.0 : 0.0;
            }
            return {std::sqrt(square / std::max(1.0, count))};
          }};
}

}  // namespace voltlap::plant
