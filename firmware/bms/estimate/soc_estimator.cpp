// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_estimator.hpp"

#include "bms/estimate/soc_coulomb.hpp"
#include "bms/estimate/soc_ekf.hpp"
#include "bms/estimate/soc_none.hpp"

namespace voltlap::bms {

void estimate_soc(const Config& config, const SocInput& input, SocEstimate& state) {
  switch (config.soc_method) {
    case SocMethod::kNone: soc_none(state); break;
    case SocMethod::kCoulomb: soc_coulomb(config, input, state); break;
    case SocMethod::kEkf: soc_ekf(config, input, state); break;
  }
}

bool soc_ready(const Config& config, const SocEstimate& state) {
  return state.valid || config.soc_method == SocMethod::kNone;
}

}  // namespace voltlap::bms
