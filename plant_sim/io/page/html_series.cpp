// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_series.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Bytes = std::vector<unsigned char>;

void append_leb128(std::uint64_t value, Bytes& out) {
  for (; value >= 0x80U; value >>= 7U) out.push_back(static_cast<unsigned char>((value & 0x7FU) | 0x80U));
  out.push_back(static_cast<unsigned char>(value));
}

std::uint64_t zigzag(std::int64_t difference) {
  return difference >= 0 ? 2U * static_cast<std::uint64_t>(difference)
                         : 2U * static_cast<std::uint64_t>(-difference) - 1U;
}

std::string base64_of(const Bytes& bytes) {
  std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');  // the encoder ends with a zero byte
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()), bytes.data(), static_cast<int>(bytes.size()));
  out.resize(static_cast<std::size_t>(length));
  return out;
}

}  // namespace

void HtmlSeries::add(double value) {
  VOLTLAP_DEMAND(resolution_ > 0.0);
  constexpr double kLimit = std::numeric_limits<std::int32_t>::max();
  const double steps = std::round(value / resolution_);
  steps_.push_back(std::isfinite(steps) ? static_cast<std::int32_t>(std::clamp(steps, -kLimit, kLimit)) : 0);
}

void HtmlSeries::halve() {
  const std::size_t kept = (steps_.size() + 1) / 2;
  for (std::size_t i = 1; i < kept; ++i) steps_[i] = steps_[2 * i];
  steps_.resize(kept);
}

std::string HtmlSeries::base64() const {
  Bytes bytes;
  bytes.reserve(steps_.size() * 2);
  std::int64_t last = 0;
  for (const std::int32_t step : steps_) {
    append_leb128(zigzag(step - last), bytes);
    last = step;
  }
  return base64_of(bytes);
}

}  // namespace voltlap::plant
