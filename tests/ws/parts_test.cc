#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/service/ws/access.h"
#include "server/service/ws/asset_table.h"
#include "server/service/ws/metrics_page.h"
#include "server/service/ws/router.h"
#include "tests/support/temporary_folder.h"

namespace kerf::ws {
namespace {

namespace fs = std::filesystem;

TEST(Endpoint, AcceptsHostAndPortOnly) {
  const Result<Endpoint> v4 = parse_endpoint("127.0.0.1:8080");
  ASSERT_TRUE(v4.ok());
  EXPECT_EQ(v4->host, "127.0.0.1");
  EXPECT_EQ(v4->port, 8080);
  const Result<Endpoint> v6 = parse_endpoint("[::1]:0");
  ASSERT_TRUE(v6.ok());
  EXPECT_EQ(v6->host, "::1");
  EXPECT_EQ(format_endpoint(v6->host, 9), "[::1]:9");
  for (const char* bad : {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:+1",
                          "127.0.0.1:80x", "::1:80", "[::1]", "[::1:80", "[nonsense]:80", "a b:80", "host:8:8"}) {
    const Result<Endpoint> endpoint = parse_endpoint(bad);
    ASSERT_FALSE(endpoint.ok()) << bad;
    EXPECT_EQ(endpoint.error().reason, "BAD_ADDRESS") << bad;
  }
}

TEST(Endpoint, KnowsWhatOnlyThisMachineReaches) {
  for (const char* host : {"localhost", "LocalHost", "127.0.0.1", "127.255.0.3", "::1"}) {
    EXPECT_TRUE(is_loopback(host)) << host;
  }
  for (const char* host : {"", "0.0.0.0", "::", "192.168.0.1", "128.0.0.1", "localhost.example.org", "127.0.0.1.nip.io",
                           "::ffff:127.0.0.1"}) {
    EXPECT_FALSE(is_loopback(host)) << host;
  }
}

TEST(Access, OnLoopbackAnswersOnlyForNamesOfThisMachine) {
  const AccessPolicy policy{true, {"https://viewer.example.org"}};
  for (const char* host : {"127.0.0.1:8080", "localhost:8080", "localhost", "[::1]:8080", "viewer.example.org:8080"}) {
    EXPECT_TRUE(check_host(policy, host).ok()) << host;
  }
  const Status rebound = check_host(policy, "evil.example.org:8080");
  ASSERT_FALSE(rebound.ok());
  EXPECT_EQ(rebound.error().reason, "HOST_NOT_ALLOWED");
  for (const char* host : {"", "a b", "host:port", "user@localhost", "localhost/path"}) {
    const Status malformed = check_host(policy, host);
    ASSERT_FALSE(malformed.ok()) << host;
    EXPECT_EQ(malformed.error().code, ErrorCode::kInvalidArgument) << host;
  }
  EXPECT_TRUE(check_host({false, {}}, "anything.example.org").ok());
}

TEST(Access, LetsInItsOwnPagesAndThoseThatAreAllowed) {
  const AccessPolicy loopback{true, {"https://viewer.example.org"}, 8080};
  for (const char* origin : {"", "http://127.0.0.1:8080", "http://localhost:8080", "http://LOCALHOST:8080",
                             "http://[::1]:8080", "https://viewer.example.org"}) {
    EXPECT_TRUE(check_origin(loopback, origin, "127.0.0.1:8080").ok()) << origin;
  }
  EXPECT_TRUE(check_origin(loopback, "http://localhost:9000", "localhost:9000").ok())
      << "a port that is forwarded here";
  EXPECT_FALSE(check_origin(loopback, "http://localhost:9000", "127.0.0.1:9000").ok());
  for (const char* origin :
       {"http://localhost:1", "http://localhost", "http://127.0.0.1:8081", "http://[::1]:80", "https://127.0.0.1:8080",
        "https://localhost:8080", "http://127.0.0.2:8080", "http://user@127.0.0.1:8080", "http://127.0.0.1:8080/",
        "ws://127.0.0.1:8080", "null", "http://evil.example.org", "https://viewer.example.org.evil.org", "file://",
        "http://127.0.0.1.evil.org", "http://localhost@evil.org", "https://viewer.example.org:444",
        "http://viewer.example.org", "chrome-extension://abc"}) {
    const Status refused = check_origin(loopback, origin, "127.0.0.1:8080");
    ASSERT_FALSE(refused.ok()) << origin;
    EXPECT_EQ(refused.error().reason, "ORIGIN_NOT_ALLOWED") << origin;
  }
}

TEST(Access, OnAPublicBindOnlyTheSameOriginIsLetIn) {
  const AccessPolicy open{false, {}};
  EXPECT_TRUE(check_origin(open, "http://kerf.example.org:8080", "kerf.example.org:8080").ok());
  EXPECT_FALSE(check_origin(open, "https://kerf.example.org", "kerf.example.org").ok())
      << "behind TLS it is to be allowed";
  EXPECT_FALSE(check_origin(open, "https://kerf.example.org:443", "kerf.example.org:443").ok());
  EXPECT_TRUE(check_origin(open, "http://kerf.example.org", "kerf.example.org:80").ok());
  EXPECT_FALSE(check_origin(open, "http://kerf.example.org", "kerf.example.org:8080").ok());
  EXPECT_FALSE(check_origin(open, "http://localhost:8080", "kerf.example.org:8080").ok());
}

TEST(Access, OverTlsItsOwnPagesAreThoseOfHttps) {
  const AccessPolicy open{.bound_to_loopback = false, .allowed_origins = {}, .port = 443, .is_secure = true};
  EXPECT_TRUE(check_origin(open, "https://kerf.example.org", "kerf.example.org").ok());
  EXPECT_TRUE(check_origin(open, "https://kerf.example.org", "kerf.example.org:443").ok());
  EXPECT_TRUE(check_origin(open, "https://kerf.example.org:8443", "kerf.example.org:8443").ok());
  EXPECT_FALSE(check_origin(open, "https://kerf.example.org", "kerf.example.org:80").ok());
  EXPECT_FALSE(check_origin(open, "http://kerf.example.org", "kerf.example.org").ok());
  EXPECT_FALSE(check_origin(open, "https://localhost", "kerf.example.org").ok());
  const AccessPolicy loopback{.bound_to_loopback = true, .allowed_origins = {}, .port = 8443, .is_secure = true};
  EXPECT_TRUE(check_origin(loopback, "https://localhost:8443", "127.0.0.1:8443").ok());
  EXPECT_FALSE(check_origin(loopback, "http://localhost:8443", "127.0.0.1:8443").ok());
}

class AssetTableTest : public ::testing::Test {
 protected:
  void write(const std::string& path, const std::string& content) const { folder_.write(path, content); }
  test::TemporaryFolder folder_;
};

TEST_F(AssetTableTest, ServesWhatWasThereWhenItWasRead) {
  write("viewer/index.html", "<p>one</p>");
  write("viewer/assets/app-1a2b.js", std::string("let a\0b", 7));
  write("viewer/empty.css", "");
  const Result<AssetTable> table = AssetTable::read(folder_ / "viewer");
  ASSERT_TRUE(table.ok()) << table.error().message;
  write("viewer/index.html", "<p>two</p>");
  const Asset* index = table->find("/");
  ASSERT_NE(index, nullptr);
  EXPECT_EQ(index, table->find("/index.html"));
  EXPECT_EQ(*index->original.bytes, "<p>one</p>");
  EXPECT_EQ(index->media_type, "text/html; charset=utf-8");
  EXPECT_FALSE(index->immutable);
  const Asset* script = table->find("/assets/app-1a2b.js");
  ASSERT_NE(script, nullptr);
  EXPECT_EQ(script->original.bytes->size(), 7U);
  EXPECT_EQ(script->media_type, "text/javascript; charset=utf-8");
  EXPECT_TRUE(script->immutable);
  EXPECT_NE(script->original.etag, index->original.etag);
  const Asset* style = table->find("/empty.css");
  ASSERT_NE(style, nullptr);
  EXPECT_TRUE(style->original.bytes->empty());

  const Result<AssetTable> again = AssetTable::read(folder_ / "viewer");
  ASSERT_TRUE(again.ok());
  EXPECT_NE(again->find("/")->original.etag, index->original.etag);
  EXPECT_EQ(again->find("/assets/app-1a2b.js")->original.etag, script->original.etag);
}

TEST_F(AssetTableTest, KnowsNoPathOutOfTheFolder) {
  write("secret.txt", "secret");
  write("viewer/index.html", "x");
  write("viewer/.git/config", "secret");
  write("viewer/.hidden", "secret");
  fs::create_symlink(folder_ / "secret.txt", folder_ / "viewer" / "link.txt");
  fs::create_directory_symlink(folder_.path(), folder_ / "viewer" / "up");
  const Result<AssetTable> table = AssetTable::read(folder_ / "viewer");
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->num_files(), 1U);
  for (const char* path : {"/../secret.txt", "/..%2fsecret.txt", "/%2e%2e/secret.txt", "//secret.txt", "/./index.html",
                           "/assets/../index.html", "/link.txt", "/up/secret.txt", "/.git/config", "/.hidden", "",
                           "index.html", "/index.html/"}) {
    EXPECT_EQ(table->find(path), nullptr) << path;
  }
  EXPECT_EQ(table->find(std::string_view("/index.html\0.png", 16)), nullptr);
}

TEST_F(AssetTableTest, RefusesAFolderThatIsNoViewer) {
  const Result<AssetTable> missing = AssetTable::read(folder_ / "none");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().reason, "VIEWER_UNREADABLE");
  write("viewer/main.js", "x");
  const Result<AssetTable> no_index = AssetTable::read(folder_ / "viewer");
  ASSERT_FALSE(no_index.ok());
  EXPECT_NE(no_index.error().message.find("index.html"), std::string::npos);
}

TEST(MediaType, GoesByTheExtension) {
  EXPECT_EQ(media_type_of("/a.WASM"), "application/wasm");
  EXPECT_EQ(media_type_of("/a.b/c"), "application/octet-stream");
  EXPECT_EQ(media_type_of("/a.tar.png"), "image/png");
  EXPECT_EQ(media_type_of("/a.unknown"), "application/octet-stream");
}

TEST(MetricsPage, ShowsEveryCountUnderItsName) {
  host::HostMetrics host;
  host.ticks = 123456789;
  host.running_sheets = 3;
  host.overload_refusals = 9;
  host.worker_need = 1'250'000;
  host.slipped_s = 0.5;
  host.flagged_ticks[1] = 6;
  host.self_contact = {
      .phases = 31, .searches = 32, .contacts = 33, .repairs = 34, .zones = 35, .unsettled = 36, .intersections = 37};
  host.tick_duration.counts[0] = 2;
  host.tick_duration.counts[3] = 5;
  host.tick_duration.counts.back() = 1;
  host.tick_duration.total = 8;
  host.linear_iterations = 70;
  host.linear_residual.add(0.5);
  host.tick_duration.sum = 2.25;
  HttpCounts http;
  http.requests = 7;
  const api::PictureCounts pictures{11, 12, 13, 14, 15, 16};
  const std::string page =
      metrics_page(host, http, {8, 3, 5, 2}, 4, {17, 18}, pictures, {19, 20, 21, 22, 23}, 1'803'859'200, "1.2.3");
  for (const char* line : {"# TYPE kerf_ticks_total counter\n",
                           "kerf_ticks_total 123456789\n",
                           "kerf_sheets{state=\"running\"} 3\n",
                           "kerf_sheets{state=\"failed\"} 0\n",
                           "kerf_slipped_seconds_total 0.5\n",
                           "kerf_flagged_ticks_total{flag=\"substepped\"} 6\n",
                           "kerf_flagged_ticks_total{flag=\"repaired\"} 0\n",
                           "# TYPE kerf_tick_duration_seconds histogram\n",
                           "kerf_tick_duration_seconds_bucket{le=\"1e-05\"} 2\n",
                           "kerf_tick_duration_seconds_bucket{le=\"+Inf\"} 8\n",
                           "kerf_tick_duration_seconds_count 8\n",
                           "kerf_tick_duration_seconds_sum 2.25\n",
                           "# TYPE kerf_self_contact_phases_total counter\n",
                           "kerf_self_contact_phases_total 31\n",
                           "kerf_self_contact_searches_total 32\n",
                           "kerf_self_contact_contacts_total 33\n",
                           "kerf_self_contact_repairs_total 34\n",
                           "kerf_self_contact_zones_total 35\n",
                           "kerf_self_contact_unsettled_total 36\n",
                           "kerf_self_contact_intersections_total 37\n",
                           "kerf_linear_iterations_total 70\n",
                           "kerf_linear_residual_bucket{le=\"0.1\"} 0\n",
                           "kerf_linear_residual_bucket{le=\"1\"} 1\n",
                           "kerf_overload_refusals_total 9\n",
                           "kerf_needed_workers 1.25\n",
                           "process_cpu_seconds_total ",
                           "process_resident_memory_bytes ",
                           "kerf_http_requests_total 7\n",
                           "kerf_grpc_connections_total 8\n",
                           "kerf_grpc_open_connections 3\n",
                           "kerf_grpc_refused_connections_total{limit=\"all\"} 5\n",
                           "kerf_grpc_refused_connections_total{limit=\"address\"} 2\n",
                           "process_open_fds ",
                           "kerf_watch_streams 4\n",
                           "kerf_frames_encoded_total 17\n",
                           "kerf_frames_sent_total 18\n",
                           "kerf_pictures_rendered_total 11\n",
                           "kerf_pictures_encoded_total 12\n",
                           "kerf_pictures_shared_total 13\n",
                           "kerf_pictures_sent_total 14\n",
                           "kerf_pictures_skipped_total 15\n",
                           "kerf_image_streams 16\n",
                           "kerf_recordings_open 19\n",
                           "kerf_recordings_stopped 20\n",
                           "kerf_recording_waiting_bytes 21\n",
                           "kerf_recording_errors_total 22\n",
                           "kerf_recording_bytes_total 23\n",
                           "kerf_build_info{version=\"1.2.3\"} 1\n"}) {
    EXPECT_NE(page.find(line), std::string::npos) << line << "is not in\n" << page;
  }
}

}  // namespace
}  // namespace kerf::ws
