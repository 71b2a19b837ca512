#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>

struct sockaddr;

namespace kerf {

// Identifies the other end of a connection for limits: an IPv4 address, also one mapped into IPv6, or the first 64 bits
// of an IPv6 address.
struct Peer {
  std::uint64_t high = 0;
  std::uint64_t low = 0;
  auto operator<=>(const Peer&) const = default;
};

// Counts addresses of other families as one peer.
Peer peer_of(const sockaddr& address);

// Counts the connections that each peer has open. Thread-safe.
class PeerPlaces {
 public:
  // A connection's place among those of its peer; its destruction frees the place. Its PeerPlaces outlive it.
  class Place {
   public:
    ~Place();
    Place(Place&& other) noexcept;
    Place& operator=(Place&& other) noexcept;
    [[nodiscard]] const Peer& peer() const { return peer_; }

   private:
    friend class PeerPlaces;
    Place(PeerPlaces* owner, const Peer& peer) : owner_(owner), peer_(peer) {}
    PeerPlaces* owner_;  // null of one that was moved from
    Peer peer_;
  };

  // At most `most` places a peer, >= 0; 0: no limit.
  explicit PeerPlaces(int most) : most_(most) {}
  PeerPlaces(const PeerPlaces&) = delete;
  PeerPlaces& operator=(const PeerPlaces&) = delete;

  // Returns a place, or nothing if the peer has as many as allowed. Throws bad_alloc, and takes no place then.
  [[nodiscard]] std::optional<Place> take(const Peer& peer);
  // Places that the peer has now.
  [[nodiscard]] int taken(const Peer& peer) const;

 private:
  void give_back(const Peer& peer);

  const int most_;
  mutable std::mutex mutex_;
  std::map<Peer, int> taken_;  // only peers that have any; guarded by mutex_
};

}  // namespace kerf
