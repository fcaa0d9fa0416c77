// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/member_effect.hpp"

namespace voltlap::plant {
namespace {

using Eigen::VectorXd;

LogFacts with_mean_higher(const LogFacts& facts, Balance balance, const VectorXd& by) {
  LogFacts out = facts;
  if (balance == Balance::kHeat) {
    out.temperature_c += by;
    out.initial_temperature_c += by(0);
  } else {
    out.voltage_v += by;
    out.rest_voltage_v += by(0);
  }
  return out;
}

}  // namespace

std::vector<VectorXd> member_effect(const World& model, const Comparison& on, const Prediction& base,
                                    const Group& group, const VectorXd& on_member, std::size_t members,
                                    bool of_sensor) {
  constexpr double kStep = 0.1, kNothing = 1e-12;  // of the effect: the derivative is what counts
  const double share = static_cast<double>(members) / static_cast<double>(group.members.size());
  const VectorXd on_mean = share * on_member;
  const Prediction changed = predict(model, on, with_mean_higher(on.facts, group.balance, kStep * on_mean));
  const std::string_view mean = group.balance == Balance::kHeat ? "temperature" : "voltage";
  std::vector<VectorXd> out;
  for (std::size_t c = 0; c < on.channels.size(); ++c) {
    VectorXd effect = (base.channels[c] - changed.channels[c]) / kStep;
    if (on.channels[c].name == mean) effect += on_mean;
    // A sensor's error stands in the sum of the readings too, against a pack voltage that does not have it.
    if (of_sensor && group.balance == Balance::kVoltage && on.channels[c].name == "pack_voltage" && c > 0) {
      effect -= static_cast<double>(members) * on_member;
    }
    effect = effect.array().isFinite().select(effect, 0.0);
    out.push_back(effect.cwiseAbs().maxCoeff() > kNothing ? effect : VectorXd());
  }
  return out;
}

}  // namespace voltlap::plant
