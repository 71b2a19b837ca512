#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/un.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/catch_exceptions.h"
#include "server/base/crc32c.h"
#include "server/base/descriptors.h"
#include "server/base/interruption.h"
#include "server/base/memory_headroom.h"
#include "server/base/memory_limit.h"
#include "server/base/memory_release.h"
#include "server/base/peer_places.h"
#include "server/base/process_usage.h"
#include "server/base/random.h"
#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "tests/support/sanitizer.h"
#include "tests/support/temporary_folder.h"

namespace kerf {
namespace {

Result<int> half_of(int value) {
  if (value % 2 != 0) return invalid_argument("ODD", "value must be even", "value");
  return value / 2;
}

TEST(Result, HoldsValueOrError) {
  EXPECT_EQ(*half_of(8), 4);
  const Result<int> refused = half_of(7);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().reason, "ODD");
  EXPECT_EQ(refused.error().field, "value");
}

// Asked by ok() alone: `if (result)` would be true of a Result<bool> that holds false.
static_assert(!std::is_constructible_v<bool, Result<bool>>);

Result<std::unique_ptr<int>> quarter_of(int value) {
  KERF_TRY(half_of(value));
  KERF_TRY_ASSIGN(const int half, half_of(value));
  int quarter = 0;
  KERF_TRY_ASSIGN(quarter, half_of(half));
  return std::make_unique<int>(quarter);
}

TEST(Result, IsTriedForItsErrorOrItsValue) {
  EXPECT_EQ(**quarter_of(12), 3);
  EXPECT_EQ(quarter_of(7).error().message, half_of(7).error().message);
  EXPECT_EQ(quarter_of(14).error().message, half_of(7).error().message);
}

TEST(Result, HasAnErrorOfEachCode) {
  EXPECT_EQ(invalid_argument("R", "m").code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(not_found("R", "m").code, ErrorCode::kNotFound);
  EXPECT_EQ(already_exists("R", "m").code, ErrorCode::kAlreadyExists);
  EXPECT_EQ(resource_exhausted("R", "m").code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(failed_precondition("R", "m").code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(aborted("R", "m").code, ErrorCode::kAborted);
  EXPECT_EQ(unauthenticated("R", "m").code, ErrorCode::kUnauthenticated);
  EXPECT_EQ(permission_denied("R", "m").code, ErrorCode::kPermissionDenied);
  EXPECT_EQ(unavailable("R", "m").code, ErrorCode::kUnavailable);
  EXPECT_EQ(data_loss("R", "m").code, ErrorCode::kDataLoss);
  const Error error = internal_error("REASON", "message", "field");
  EXPECT_EQ(error.code, ErrorCode::kInternal);
  EXPECT_EQ(error.reason, "REASON");
  EXPECT_EQ(error.message, "message");
  EXPECT_EQ(error.field, "field");
}

TEST(ResultDeathTest, ValueOfAFailureIsABug) {
  EXPECT_DEATH(static_cast<void>(half_of(7).value()), "value\\(\\) of a failed Result");
}

// The values are those of RFC 3720, B.4, and the usual check of nine digits.
TEST(Crc32c, HasThePublishedValues) {
  EXPECT_EQ(crc32c(""), 0U);
  EXPECT_EQ(crc32c("123456789"), 0xe3069283U);
  EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8a9136aaU);
  EXPECT_EQ(crc32c(std::string(32, '\xff')), 0x62a8ab43U);
  std::string rising(32, '\0');
  for (std::size_t i = 0; i < rising.size(); ++i) rising[i] = static_cast<char>(i);
  EXPECT_EQ(crc32c(rising), 0x46dd794eU);
  EXPECT_EQ(crc32c(std::string(rising.rbegin(), rising.rend())), 0x113fdb5cU);
}

// Divides bit by bit, as the polynomial is defined.
TEST(Crc32c, IsTheRemainderAtEveryLengthAndAlignment) {
  const std::string bytes = std::string(3, char{0}) + "x\xff\x80 any text of some fifty bytes, and zeros before it";
  for (std::size_t at = 0; at < 9; ++at) {
    for (std::size_t count = 0; count <= bytes.size() - at; ++count) {
      std::uint32_t rest = ~0U;
      for (const char byte : bytes.substr(at, count)) {
        rest ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1U) ^ ((rest & 1U) != 0 ? 0x82f63b78U : 0U);
      }
      ASSERT_EQ(crc32c(std::string_view(bytes).substr(at, count)), ~rest) << at << " " << count;
    }
  }
}

std::uint64_t hash_of(const std::vector<double>& values) {
  StateHash hash;
  hash.add_span(std::span<const double>(values));
  return hash.value();
}

TEST(StateHash, SeesEveryBitAndTheOrder) {
  const std::vector<double> values{0.0, 1.0, -2.5, 1e-300, 3.0};
  const std::uint64_t before = hash_of(values);
  EXPECT_EQ(before, hash_of(values));
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (int bit = 0; bit < 64; ++bit) {
      std::vector<double> changed = values;
      changed[i] = std::bit_cast<double>(std::bit_cast<std::uint64_t>(changed[i]) ^ (1ULL << bit));
      EXPECT_NE(before, hash_of(changed)) << "value " << i << " bit " << bit;
    }
  }
  EXPECT_NE(hash_of({1.0, 2.0}), hash_of({2.0, 1.0}));
  EXPECT_NE(hash_of({0.0}), hash_of({0.0, 0.0}));
  EXPECT_NE(hash_of({0.0}), hash_of({-0.0}));
}

TEST(StateHash, CountsTheTailOfASpanThatIsNoWholeWord) {
  const std::array<std::uint8_t, 9> a{1, 2, 3, 4, 5, 6, 7, 8, 9};
  std::array<std::uint8_t, 9> b = a;
  b[8] = 10;
  StateHash hash_a;
  hash_a.add_span(std::span<const std::uint8_t>(a));
  StateHash hash_b;
  hash_b.add_span(std::span<const std::uint8_t>(b));
  EXPECT_NE(hash_a.value(), hash_b.value());
}

TEST(SeededRandom, FollowsThePublishedSequence) {
  // First outputs of SplitMix64 from seed 1234567 (the sequence published with the algorithm).
  SeededRandom random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317ULL);
  EXPECT_EQ(random.next(), 3203168211198807973ULL);
  EXPECT_EQ(random.next(), 9817491932198370423ULL);
}

TEST(ProcessUsage, OfThisProcessGrowsAndOfNoneThereIsNone) {
  const ProcessUsage before = own_usage();
  EXPECT_GT(before.resident_bytes, 500'000);
  std::vector<double> touched(std::size_t{4} << 20, 1.0);  // 32 MiB
  std::uint64_t hash = 0;
  while (own_usage().cpu_s < before.cpu_s + 0.02) hash += hash_of(touched);
  EXPECT_GT(own_usage().resident_bytes, before.resident_bytes + (30 << 20)) << hash;
  EXPECT_FALSE(usage_of(4'194'305));  // beyond the most that the kernel gives
}

TEST(SeededRandom, StaysInItsRange) {
  SeededRandom random(7);
  double sum = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double u = random.uniform(-2.0, 3.0);
    ASSERT_GE(u, -2.0);
    ASSERT_LT(u, 3.0);
    sum += u;
    ASSERT_LT(random.below(7), 7U);
  }
  EXPECT_NEAR(sum / 10000.0, 0.5, 0.05);
}

std::filesystem::path written(const test::TemporaryFolder& folder, const std::string& groups) {
  folder.write("proc/self/cgroup", groups);
  return folder.path();
}

TEST(MemoryLimit, IsThatOfTheMachineWhereNoGroupHasLess) {
  const test::TemporaryFolder folder;
  const std::int64_t machine = memory_limit(folder.path());
  EXPECT_GT(machine, 0);
  folder.write("sys/fs/cgroup/a/memory.max", "max\n");
  folder.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(memory_limit(written(folder, "4:memory:/\n0::/a\n")), machine);
}

TEST(MemoryLimit, IsTheLeastOfTheGroupsAroundTheProcess) {
  const test::TemporaryFolder folder;
  folder.write("sys/fs/cgroup/a/memory.max", "4000000\n");
  folder.write("sys/fs/cgroup/a/b/memory.max", "5000000\n");
  EXPECT_EQ(memory_limit(written(folder, "0::/a/b\n")), 4'000'000);
  folder.write("sys/fs/cgroup/memory/c/memory.limit_in_bytes", "3000000\n");
  EXPECT_EQ(memory_limit(written(folder, "5:cpu,memory:/c/d\n0::/a/b\n")), 3'000'000);
}

// A container sees its own group as the top of the tree, whatever its name outside.
TEST(MemoryLimit, IsThatOfTheContainer) {
  const test::TemporaryFolder folder;
  folder.write("sys/fs/cgroup/memory.max", "2000000\n");
  EXPECT_EQ(memory_limit(written(folder, "0::/docker/1234\nnonsense\n9:memory:none\n")), 2'000'000);
  EXPECT_EQ(memory_limit(written(folder, "0::/\n")), 2'000'000);
}

TEST(Descriptors, AreCountedAndLimitedAsFarAsTheSystemLetsThem) {
  const std::int64_t before = num_open_descriptors();
  {
    const std::ifstream file("/proc/self/stat");
    EXPECT_EQ(num_open_descriptors(), before + 1);
  }
  EXPECT_EQ(num_open_descriptors(), before);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  limit.rlim_cur = limit.rlim_max / 2;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  EXPECT_GT(raise_descriptor_limit(), static_cast<std::int64_t>(limit.rlim_cur));
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  EXPECT_EQ(limit.rlim_cur, limit.rlim_max);
}

Peer v4_peer(const char* address) {
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  EXPECT_EQ(inet_pton(AF_INET, address, &v4.sin_addr), 1) << address;
  return peer_of(reinterpret_cast<const sockaddr&>(v4));
}

Peer v6_peer(const char* address) {
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  EXPECT_EQ(inet_pton(AF_INET6, address, &v6.sin6_addr), 1) << address;
  return peer_of(reinterpret_cast<const sockaddr&>(v6));
}

TEST(Peer, IsAnIpv4AddressOrTheFirstHalfOfAnIpv6One) {
  EXPECT_EQ(v4_peer("127.0.0.1"), v4_peer("127.0.0.1"));
  EXPECT_NE(v4_peer("127.0.0.1"), v4_peer("127.0.0.2"));
  EXPECT_NE(v4_peer("10.0.0.1"), v4_peer("11.0.0.1"));
  EXPECT_EQ(v6_peer("::ffff:10.1.2.3"), v4_peer("10.1.2.3"));
  EXPECT_NE(v6_peer("::ffff:10.1.2.3"), v6_peer("::ffff:10.1.2.4"));
  EXPECT_EQ(v6_peer("2001:db8:1:2::1"), v6_peer("2001:db8:1:2:ffff::9"));
  EXPECT_NE(v6_peer("2001:db8:1:2::1"), v6_peer("2001:db8:1:3::1"));
  EXPECT_NE(v6_peer("::1"), v4_peer("127.0.0.1"));
  const sockaddr_un local{AF_UNIX, "x"};
  EXPECT_EQ(peer_of(reinterpret_cast<const sockaddr&>(local)), Peer());
}

TEST(PeerPlaces, AreSoManyForEachPeerAndComeBack) {
  const Peer one = v4_peer("10.0.0.1");
  const Peer other = v4_peer("10.0.0.2");
  PeerPlaces places(2);
  std::optional<PeerPlaces::Place> first = places.take(one);
  std::optional<PeerPlaces::Place> second = places.take(one);
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(places.take(one));
  EXPECT_TRUE(places.take(other)) << "and given back at once";
  EXPECT_EQ(places.taken(one), 2);
  EXPECT_EQ(places.taken(other), 0);
  PeerPlaces::Place kept = *std::move(first);
  EXPECT_EQ(kept.peer(), one);
  first.reset();
  EXPECT_EQ(places.taken(one), 2) << "it was moved";
  second.reset();
  EXPECT_TRUE(places.take(one));
  EXPECT_EQ(places.taken(one), 1);
}

TEST(PeerPlaces, HaveNoLimitIfItIsZero) {
  PeerPlaces places(0);
  std::vector<PeerPlaces::Place> taken;
  for (int i = 0; i < 1000; ++i) taken.push_back(*places.take(Peer()));
  EXPECT_EQ(places.taken(Peer()), 1000);
  taken.clear();
  EXPECT_EQ(places.taken(Peer()), 0);
}

// Counts to `end`, unless it is interrupted.
int count_to(int end) {
  int i = 0;
  for (; i < end; ++i) interruption_point();
  return i;
}

TEST(Interruption, EndsWorkThatIsNotWantedAnyMore) {
  constexpr int kMany = 100 * kPointsToAPoll;
  EXPECT_EQ(count_to(kMany), kMany) << "without a scope nothing asks";
  int asked = 0;
  {
    const InterruptionScope scope([&] { return ++asked >= 5; });
    EXPECT_THROW(count_to(kMany), Interrupted);
    EXPECT_EQ(asked, 5);
    EXPECT_THROW(count_to(1), Interrupted) << "at once, where it was caught by mistake";
    const InterruptionScope inner([] { return false; });
    EXPECT_EQ(count_to(kMany), kMany) << "the innermost is asked";
  }
  EXPECT_EQ(count_to(kMany), kMany);
  const InterruptionScope always([] { return true; });
  EXPECT_EQ(catch_exceptions([]() -> Result<int> { return count_to(1); }).error().reason, "INTERRUPTED");
}

TEST(MemoryHeadroom, IsMoreThanNothingAndLessThanEverything) {
  EXPECT_TRUE(has_memory_for(0));
  EXPECT_FALSE(has_memory_for(std::int64_t{1} << 50)) << "a petabyte";
  EXPECT_FALSE(has_memory_for(std::numeric_limits<std::int64_t>::max()));
  EXPECT_GT(resident_bytes(), 0);
}

TEST(MemoryRelease, GivesBackWhatWasFreed) {
  if (test::runs_with_sanitizer()) GTEST_SKIP() << "the sanitizer has its own malloc";
  constexpr std::size_t kBytes = 64 << 10;  // below what malloc maps by itself
  std::vector<std::unique_ptr<std::vector<char>>> blocks;
  for (int i = 0; i < 1000; ++i) blocks.push_back(std::make_unique<std::vector<char>>(kBytes, 'x'));
  const auto last = std::make_unique<std::vector<char>>(kBytes, 'x');  // keeps the top of the heap
  const std::int64_t full = resident_bytes();
  blocks.clear();
  release_free_memory();
  EXPECT_LT(resident_bytes(), full - 50'000'000);
}

}  // namespace
}  // namespace kerf
