#pragma once

#include <cstdint>
#include <optional>
#include <utility>

namespace kerf::host {

// Holds back values that show changes which are not durable yet, each with the number of the last change that it
// shows. Only the oldest and the newest value are kept, so that one comes out even if there is always a newer change.
template <typename T>
class HeldBack {
 public:
  // Adds a value that shows changes up to `seq`, which never decreases.
  void add(std::int64_t seq, T value) {
    auto& place = oldest_ && oldest_->seq < seq ? newest_ : oldest_;
    place = Held{seq, std::move(value)};
  }
  // Removes and returns the newest value that shows only changes up to `durable`, and forgets older ones.
  std::optional<T> take(std::int64_t durable) {
    std::optional<T> taken;
    while (oldest_ && oldest_->seq <= durable) {
      taken = std::move(oldest_->value);
      oldest_ = std::exchange(newest_, std::nullopt);
    }
    return taken;
  }
  void clear() {
    oldest_.reset();
    newest_.reset();
  }

 private:
  struct Held {
    std::int64_t seq;
    T value;
  };
  std::optional<Held> oldest_;
  std::optional<Held> newest_;
};

}  // namespace kerf::host
