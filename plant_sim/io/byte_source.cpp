// SPDX-License-Identifier: Apache-2.0
#include "io/byte_source.hpp"

#include <zlib.h>
#include <zstd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <vector>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/input_files.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 17;
constexpr std::array<unsigned char, 2> kGzip{0x1F, 0x8B};
constexpr std::array<unsigned char, 4> kZstd{0x28, 0xB5, 0x2F, 0xFD};

template <std::size_t size>
bool begins_with(const std::vector<char>& bytes, const std::array<unsigned char, size>& magic) {
  return bytes.size() >= size && std::memcmp(bytes.data(), magic.data(), size) == 0;
}

/// Takes packed bytes and gives plain ones.
class Unpacker {
 public:
  virtual ~Unpacker() = default;
  struct Step {
    std::size_t taken = 0, given = 0;
    bool damaged = false;
  };
  virtual Step unpack(std::span<const char> packed, std::span<char> plain) = 0;
  /// Between two members or frames: a file may end here.
  [[nodiscard]] virtual bool at_boundary() const = 0;
};

class Gunzip final : public Unpacker {
 public:
  Gunzip() {
    constexpr int kGzipOnly = 16 + MAX_WBITS;
    VOLTLAP_DEMAND(inflateInit2(&state_, kGzipOnly) == Z_OK);
  }
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;
  ~Gunzip() override { inflateEnd(&state_); }

  Step unpack(std::span<const char> packed, std::span<char> plain) override {
    if (ended_) {
      inflateReset(&state_);
      ended_ = false;
    }
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    state_.avail_in = static_cast<uInt>(packed.size());
    state_.next_out = reinterpret_cast<Bytef*>(plain.data());
    state_.avail_out = static_cast<uInt>(plain.size());
    const int result = inflate(&state_, Z_NO_FLUSH);
    ended_ = result == Z_STREAM_END;
    const bool damaged = result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR;
    return {packed.size() - state_.avail_in, plain.size() - state_.avail_out, damaged};
  }
  [[nodiscard]] bool at_boundary() const override { return ended_; }

 private:
  z_stream state_{};
  bool ended_ = false;
};

class Unzstd final : public Unpacker {
 public:
  Unzstd() : state_(ZSTD_createDStream(), ZSTD_freeDStream) { VOLTLAP_DEMAND(state_ != nullptr); }

  Step unpack(std::span<const char> packed, std::span<char> plain) override {
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    ZSTD_outBuffer out{plain.data(), plain.size(), 0};
    const std::size_t left = ZSTD_decompressStream(state_.get(), &out, &in);
    ended_ = left == 0;
    return {in.pos, out.pos, ZSTD_isError(left) != 0};
  }
  [[nodiscard]] bool at_boundary() const override { return ended_; }

 private:
  std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> state_;
  bool ended_ = false;
};

}  // namespace

struct ByteSource::Stream {
  std::string path;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{nullptr, std::fclose};
  std::unique_ptr<Unpacker> unpacker;  ///< none: plain
  std::vector<char> raw;               ///< read from the file and not yet given
  std::size_t begin = 0;
  bool file_ended = false;
  std::string broken;

  void refill() {
    if (begin < raw.size() || file_ended) return;
    raw.resize(kPiece);
    const std::size_t got = std::fread(raw.data(), 1, kPiece, file.get());
    if (std::ferror(file.get()) != 0) broken = std::string("a file that cannot be read on: ") + std::strerror(errno);
    raw.resize(got);
    begin = 0;
    file_ended = got < kPiece;
  }

  std::size_t plain(std::span<char> into) {
    refill();
    const std::size_t count = std::min(into.size(), raw.size() - begin);
    std::memcpy(into.data(), raw.data() + begin, count);
    begin += count;
    return count;
  }

  std::size_t unpacked(std::span<char> into) {
    while (broken.empty()) {
      refill();
      const std::span<const char> packed(raw.data() + begin, raw.size() - begin);
      if (packed.empty() && unpacker->at_boundary()) return 0;
      const Unpacker::Step step = unpacker->unpack(packed, into);
      begin += step.taken;
      if (step.damaged) broken = "a compressed stream that is damaged";
      if (step.given > 0) return step.given;
      if (begin < raw.size() && step.taken == 0 && !step.damaged) broken = "a compressed stream that is damaged";
      if (begin == raw.size() && file_ended && !unpacker->at_boundary()) broken = "a compressed stream that breaks off";
    }
    return 0;
  }
};

ByteSource::ByteSource(const std::string& path, const char* expected) : stream_(std::make_unique<Stream>()) {
  stream_->path = path;
  stream_->file.reset(std::fopen(path.c_str(), "rb"));
  const int cause = errno;
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  if (!stream_->file || folder) {
    throw InputError(path, folder ? "a folder" : std::string("no file that can be opened: ") + std::strerror(cause),
                     expected, "Check the path and that you may read it");
  }
  note_input(path);
  stream_->refill();
  if (begins_with(stream_->raw, kGzip)) stream_->unpacker = std::make_unique<Gunzip>();
  if (begins_with(stream_->raw, kZstd)) stream_->unpacker = std::make_unique<Unzstd>();
}

ByteSource::~ByteSource() = default;
ByteSource::ByteSource(ByteSource&&) noexcept = default;
ByteSource& ByteSource::operator=(ByteSource&&) noexcept = default;

std::size_t ByteSource::read(std::span<char> into) {
  VOLTLAP_DEMAND(!into.empty());
  return stream_->unpacker ? stream_->unpacked(into) : stream_->plain(into);
}

const std::string& ByteSource::broken() const {
  return stream_->broken;
}

}  // namespace voltlap::plant
