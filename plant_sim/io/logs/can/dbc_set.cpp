// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/dbc_set.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"

namespace voltlap::plant {
namespace {

bool is_same(const DbcSignal& a, const DbcSignal& b) {
  return a.name == b.name && a.length == b.length && a.kind == b.kind && a.scale == b.scale && a.offset == b.offset &&
         a.bits == b.bits;
}

bool is_same(const DbcMessage& a, const DbcMessage& b) {
  return std::equal(a.signals.begin(), a.signals.end(), b.signals.begin(), b.signals.end(),
                    [](const DbcSignal& x, const DbcSignal& y) { return is_same(x, y); });
}

}  // namespace

DbcSet::DbcSet(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    auto file = std::make_unique<DbcFile>(path);
    for (const DbcMessage& message : file->messages()) {
      const CompiledMessage* other = find(message.id);
      if (other == nullptr || is_same(other->message(), message)) continue;
      throw InputError(path, fmt::format("frame {} ({}) as in {} ({}), with other signals", identifier_text(message.id),
                                         message.name, other->message().file, other->message().name),
                       "each frame in one of the DBC files", "Leave out the file that is not of this recording");
    }
    decoders_.push_back(std::make_unique<DbcDecoder>(*file));
    files_.push_back(std::move(file));
  }
}

const CompiledMessage* DbcSet::find(std::uint32_t id) const {
  for (const auto& decoder : decoders_) {
    if (const CompiledMessage* message = decoder->find(id)) return message;
  }
  return nullptr;
}

const DbcRefusal* DbcSet::refusal(std::uint32_t id) const {
  for (const auto& file : files_) {
    for (const DbcRefusal& refusal : file->refused()) {
      if (refusal.id == id) return &refusal;
    }
  }
  return nullptr;
}

std::size_t DbcSet::most_signals() const {
  std::size_t out = 0;
  for (const auto& decoder : decoders_) out = std::max(out, decoder->most_signals());
  return out;
}

}  // namespace voltlap::plant
