#include "server/base/peer_places.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>
#include <utility>

namespace kerf {
namespace {

constexpr std::uint64_t kMapped = 0xffff'0000'0000;  // ::ffff:0:0/96, where IPv6 maps IPv4 addresses

std::uint64_t big_endian(const unsigned char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = (value << 8U) | bytes[i];
  return value;
}

}  // namespace

Peer peer_of(const sockaddr& address) {
  if (address.sa_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address, sizeof(v4));
    return {0, kMapped | ntohl(v4.sin_addr.s_addr)};
  }
  if (address.sa_family != AF_INET6) return {};
  sockaddr_in6 v6{};
  std::memcpy(&v6, &address, sizeof(v6));
  const unsigned char* bytes = v6.sin6_addr.s6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) return {0, big_endian(bytes + 8, 8)};
  return {big_endian(bytes, 8), 0};
}

PeerPlaces::Place::Place(Place&& other) noexcept : owner_(std::exchange(other.owner_, nullptr)), peer_(other.peer_) {}

PeerPlaces::Place& PeerPlaces::Place::operator=(Place&& other) noexcept {
  std::swap(owner_, other.owner_);
  std::swap(peer_, other.peer_);
  return *this;
}

PeerPlaces::Place::~Place() {
  if (owner_ != nullptr) owner_->give_back(peer_);
}

std::optional<PeerPlaces::Place> PeerPlaces::take(const Peer& peer) {
  const std::lock_guard lock(mutex_);
  int& places = taken_[peer];
  if (most_ > 0 && places >= most_) return std::nullopt;
  ++places;
  return Place(this, peer);
}

int PeerPlaces::taken(const Peer& peer) const {
  const std::lock_guard lock(mutex_);
  const auto found = taken_.find(peer);
  return found == taken_.end() ? 0 : found->second;
}

void PeerPlaces::give_back(const Peer& peer) {
  const std::lock_guard lock(mutex_);
  const auto found = taken_.find(peer);
  if (--found->second == 0) taken_.erase(found);
}

}  // namespace kerf
