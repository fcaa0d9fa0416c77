// SPDX-License-Identifier: Apache-2.0
#include "fake_registers.hpp"

#include <map>

#include "port/stm32/register.hpp"

namespace voltlap::port::stm32 {
namespace test {
namespace {

struct Block {
  std::size_t bytes;
  Model* model;
};
std::map<std::uintptr_t, Block>& blocks() {
  static std::map<std::uintptr_t, Block> all;
  return all;
}
std::function<void()>& waiting() {
  static std::function<void()> what;
  return what;
}

Model* model_of(const void* at, std::size_t& offset) {
  const auto address = reinterpret_cast<std::uintptr_t>(at);
  auto next = blocks().upper_bound(address);
  if (next == blocks().begin()) return nullptr;
  --next;
  offset = address - next->first;
  return offset < next->second.bytes ? next->second.model : nullptr;
}

}  // namespace

Attached::Attached(const void* first, std::size_t bytes, Model& model) : first_(first) {
  blocks()[reinterpret_cast<std::uintptr_t>(first)] = {bytes, &model};
}
Attached::~Attached() { blocks().erase(reinterpret_cast<std::uintptr_t>(first_)); }

void on_wait_for_interrupt(std::function<void()> what) { waiting() = std::move(what); }

}  // namespace test

std::uint32_t Register::read() const {
  std::size_t offset = 0;
  test::Model* const model = test::model_of(this, offset);
  return model == nullptr ? word_ : model->read(offset);
}
void Register::write(std::uint32_t value) {
  std::size_t offset = 0;
  test::Model* const model = test::model_of(this, offset);
  if (model == nullptr) {
    word_ = value;
  } else {
    model->write(offset, value);
  }
}
void wait_for_interrupt() {
  if (test::waiting()) test::waiting()();
}

}  // namespace voltlap::port::stm32
