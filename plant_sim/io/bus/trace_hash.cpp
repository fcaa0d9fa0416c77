// SPDX-License-Identifier: Apache-2.0
#include "io/bus/trace_hash.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <stdexcept>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kBlockBytes = 1U << 14;  // few calls into the library

void require(bool ok) {
  if (!ok) throw std::runtime_error("the SHA-256 of the cryptography library failed");
}

void put_u32(std::uint8_t* at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  require(context_ != nullptr && EVP_DigestInit_ex(context_, EVP_sha256(), nullptr) == 1);
  pending_.reserve(kBlockBytes);
}

Sha256::~Sha256() { EVP_MD_CTX_free(context_); }

void Sha256::add(const std::uint8_t* bytes, std::size_t count) {
  pending_.insert(pending_.end(), bytes, bytes + count);
  if (pending_.size() + count > kBlockBytes) flush();
}

void Sha256::flush() {
  require(EVP_DigestUpdate(context_, pending_.data(), pending_.size()) == 1);
  pending_.clear();
}

std::string Sha256::finish() {
  flush();
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned length = 0;
  require(EVP_DigestFinal_ex(context_, digest.data(), &length) == 1);
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < length; ++i) text += {kDigits[digest[i] >> 4], kDigits[digest[i] & 15]};
  return text;
}

void TraceHash::on_frame(std::uint32_t tick, Sender sender, const Frame& frame) {
  VOLTLAP_DEMAND(static_cast<std::size_t>(sender) < kSenders);
  constexpr std::size_t kHead = 10;
  std::array<std::uint8_t, kHead + Frame::kMaxBytes> record;
  put_u32(record.data(), tick);
  record[4] = static_cast<std::uint8_t>(sender);
  put_u32(record.data() + 5, frame.id);
  record[9] = frame.dlc;
  const std::size_t bytes = std::min<std::size_t>(frame.dlc, Frame::kMaxBytes);
  std::copy_n(frame.data, bytes, record.begin() + kHead);
  trace_.add(record.data(), kHead + bytes);
  node_[static_cast<std::size_t>(sender)].add(record.data(), kHead + bytes);
}

TraceHash::Result TraceHash::finish() {
  return {trace_.finish(), node_[0].finish(), node_[1].finish(), node_[2].finish()};
}

}  // namespace voltlap::plant
