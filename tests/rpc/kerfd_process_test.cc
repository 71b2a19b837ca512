#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "client/cpp/client.h"
#include "kerf/v1/sheets.pb.h"
#include "render/renderer.h"
#include "server/app/config.h"
#include "server/app/site_folders.h"
#include "server/base/memory_limit.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/wire/json.h"
#include "tests/rpc/kerfd_process.h"

namespace kerf::rpc_test {
namespace {

namespace fs = std::filesystem;
using ws_test::request;

TEST_F(KerfdTest, PrintsOneLineWhenReadyAndStopsOnASignal) {
  for (const int number : {SIGTERM, SIGINT}) {
    const std::string scene = write("first.json", kScene);
    const std::string named = write("second.json", R"({"sheet_id": "named",
      "grid": {"columns": 5, "rows": 4, "width_m": 1, "height_m": 1}})");
    Kerfd kerfd(free_ports({"--scene", scene, "--scene", named, "--workers", "1"}));
    const std::string line = kerfd.read_line();
    std::smatch match;
    ASSERT_TRUE(std::regex_match(
        line, match, std::regex(R"re(\{"grpc":"127\.0\.0\.1:([0-9]+)","http":"http://127\.0\.0\.1:([0-9]+)"\}\n)re")))
        << line;
    const int port = std::stoi(match[2]);
    v1::ListSheetsResponse sheets;
    ASSERT_TRUE(wire::from_json(request(port, "POST", "/kerf.v1.SheetService/ListSheets", {}, "{}").body, sheets).ok());
    ASSERT_EQ(sheets.sheets_size(), 2);
    EXPECT_EQ(sheets.sheets(0).name(), "sheets/first") << "without sheet_id the file's name serves";
    EXPECT_NE(sheets.sheets(0).run_state(), v1::Sheet::PAUSED);
    EXPECT_EQ(sheets.sheets(1).name(), "sheets/named");
    EXPECT_EQ(sheets.sheets(1).num_vertices(), 20);
    kerfd.signal(number);
    EXPECT_EQ(kerfd.wait(), 0);
    EXPECT_EQ(kerfd.rest_of_output(), "");
  }
}

TEST_F(KerfdTest, StopsWithViewersAndWorkUnderWay) {
  Kerfd kerfd(free_ports({"--scene", write("a.json", kScene)}));
  const std::string line = kerfd.read_line();
  ASSERT_NE(line, "");
  const int port = std::stoi(line.substr(line.rfind(':') + 1));
  ws_test::RawWebSocket viewer(port);
  ASSERT_EQ(viewer.handshake().status, 101);
  viewer.send(ws_test::RawWebSocket::kBinary, "\x0a\x0a\x0a\x08sheets/a");
  ASSERT_TRUE(viewer.read());
  ws_test::RawClient half(port);
  half.send("POST /kerf.v1.SheetService/ListSheets HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n{");
  kerfd.signal(SIGTERM);
  EXPECT_EQ(viewer.read_close(), 1001);
  EXPECT_EQ(kerfd.wait(), 0);
}

// Simulates Ctrl-C when a script around kerfd passes on the signal that the terminal sends to both.
TEST_F(KerfdTest, TwoSignalsAtOnceAreOneWish) {
  Kerfd kerfd(free_ports({"--scene", write("a.json", kScene)}));
  const std::unique_ptr<ws_test::RawClient> half = unfinished_request(kerfd);
  kerfd.signal(SIGINT);
  kerfd.signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
}

TEST_F(KerfdTest, ALaterSignalEndsItAtOnce) {
  Kerfd kerfd(free_ports());
  const std::unique_ptr<ws_test::RawClient> half = unfinished_request(kerfd);
  kerfd.signal(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  kerfd.signal(SIGINT);
  EXPECT_EQ(kerfd.wait(), -SIGINT);
}

// gRPC's own listening ends for good where the process runs out of descriptors.
TEST_F(KerfdTest, WithFewDescriptorsAFloodOfConnectionsLeavesBothPortsAnswering) {
  Kerfd kerfd(free_ports(), "-n 64");
  const std::string line = kerfd.read_line();
  std::smatch match;
  ASSERT_TRUE(std::regex_search(line, match, std::regex(R"(127\.0\.0\.1:([0-9]+).*127\.0\.0\.1:([0-9]+))"))) << line;
  const int grpc = std::stoi(match[1]);
  const int http = std::stoi(match[2]);
  for (int i = 0; i < 1000; ++i) ws_test::RawClient at_once(grpc);
  std::vector<std::unique_ptr<ws_test::RawClient>> held;
  for (int i = 0; i < 100; ++i) held.push_back(std::make_unique<ws_test::RawClient>(http));
  client::Client client("127.0.0.1:" + std::to_string(grpc));
  v1::ListSheetsResponse sheets;
  const grpc::Status status =
      client.call(&v1::SheetService::Stub::ListSheets, client.sheets(), v1::ListSheetsRequest(), sheets);
  EXPECT_TRUE(status.ok()) << status.error_message();
  held.clear();
  int answer = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
  while (answer != 200 && std::chrono::steady_clock::now() < end) {
    answer = request(http, "GET", "/metrics", {}, "").status;
  }
  EXPECT_EQ(answer, 200);
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
  EXPECT_NE(kerfd.errors().find("this process may open 64 files and connections"), std::string::npos);
}

TEST_F(KerfdTest, RecordsWhatItRuns) {
  Kerfd kerfd(free_ports({"--scene", write("a.json", kScene), "--record", folder_.path().string()}));
  ASSERT_NE(kerfd.read_line(), "");
  kerfd.signal(SIGTERM);
  ASSERT_EQ(kerfd.wait(), 0);
  int recordings = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(folder_.path())) {
    if (file.path().extension() != ".kerf") continue;
    ++recordings;
    EXPECT_EQ(file.path().filename().string().rfind("a-", 0), 0U);
    EXPECT_GT(file.file_size(), 20U);
  }
  EXPECT_EQ(recordings, 1);
}

// A limit of 512 or 1,024 bytes a file, by the shell, stands for a full disk; the scene alone is longer.
TEST_F(KerfdTest, ADiskThatTakesNoMoreEndsNothing) {
  const std::string scene = R"({"description": ")" + std::string(1000, 'x') + R"(", )" + (kScene + 1);
  const std::string written = write("a.json", scene);
  const std::string folder = folder_.path().string();
  Kerfd kerfd(free_ports({"--scene", written, "--record", folder}), "-f 1");
  const std::string line = kerfd.read_line();
  ASSERT_NE(line, "");
  const int port = std::stoi(line.substr(line.rfind(':') + 1));
  const std::string page = request(port, "GET", "/metrics", {}, "").body;
  EXPECT_NE(page.find("kerf_recordings_open 1\n"), std::string::npos) << page;
  EXPECT_NE(page.find("kerf_recordings_stopped 1\n"), std::string::npos) << page;
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
  const std::string errors = kerfd.errors();
  EXPECT_NE(errors.find(" pauses: cannot write "), std::string::npos) << errors;
  EXPECT_NE(errors.find(" ends with its sheet, "), std::string::npos) << errors;
}

TEST_F(KerfdTest, RefusesOnOneLine) {
  EXPECT_NE(refusal({"--nonsense"}).find("--help"), std::string::npos);
  EXPECT_NE(refusal({"--listen", "nowhere"}).find("HOST:PORT"), std::string::npos);
  EXPECT_NE(refusal({"--workers", "257"}).find("257"), std::string::npos);
  EXPECT_NE(refusal({"--max-sheets", "0"}).find("1..100000"), std::string::npos);
  EXPECT_NE(refusal({"--max-sheets", "100001"}).find("100001"), std::string::npos);
  for (const char* load : {"-1", "0.001", "1001", "nan"}) {
    EXPECT_NE(refusal({"--max-load", load}).find("neither 0 nor in 0.01..1000"), std::string::npos) << load;
  }
  for (const char* vertices : {"-1", "1000000000001"}) {
    EXPECT_NE(refusal({"--max-total-vertices", vertices}).find("0..1000000000000"), std::string::npos) << vertices;
  }
  // An unset variable of a script must not open the server to everybody.
  EXPECT_NE(refusal({"--tokens", ""}).find("is empty; name a file"), std::string::npos);
  EXPECT_NE(refusal({"--http", "0.0.0.0:0"}).find("give --tls-cert, --tls-key and --tokens"), std::string::npos);
  for (const std::vector<std::string>& some : {std::vector<std::string>{"--tokens", "t"},
                                               {"--tls-cert", "c", "--tls-key", "k"},
                                               {"--tokens", "t", "--tls-cert", "c", "--tls-key", "k"}}) {
    std::vector<std::string> options = some;
    options.insert(options.end(), {"--listen", "0.0.0.0:0"});
    EXPECT_NE(refusal(options).find("--tls-client-ca and --tokens"), std::string::npos);
  }
  const std::string missing = (folder_ / "missing.json").string();
  EXPECT_NE(refusal(free_ports({"--scene", missing})).find(missing), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--max-total-vertices", "2", "--scene", write("large.json", kScene)}))
                .find("together may have 2 vertices"),
            std::string::npos);
  const std::string bad = refusal(free_ports({"--scene", write("bad.json", R"({"grid": {"columns": 1, "rows": 6}})")}));
  EXPECT_NE(bad.find("grid.columns"), std::string::npos) << bad;
  const std::string twice = write("twice.json", kScene);
  EXPECT_NE(refusal(free_ports({"--scene", twice, "--scene", twice})).find("twice"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--record", (folder_ / "none").string()})).find("none\" is not a folder"),
            std::string::npos);
  EXPECT_NE(refusal(free_ports({"--record", "/proc"})).find("/proc"), std::string::npos);
  const std::string device = refusal({"--listen", "127.0.0.1:0", "--http", "127.0.0.1:0", "--render-device", "abacus"});
  EXPECT_NE(device.find("--render-device: \"abacus\" is not a device here"), std::string::npos) << device;
  EXPECT_NE(refusal(free_ports({"--render-device", "auto"})).find("--no-render"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--web", (folder_ / "none").string()})).find("none"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--docs", (folder_ / "none").string()})).find("none"), std::string::npos);
}

TEST_F(KerfdTest, RefusesATakenPort) {
  Kerfd first(free_ports());
  const std::string line = first.read_line();
  std::smatch match;
  ASSERT_TRUE(std::regex_search(line, match, std::regex(R"(127\.0\.0\.1:([0-9]+).*127\.0\.0\.1:([0-9]+))"))) << line;
  const std::string grpc = "127.0.0.1:" + match[1].str();
  const std::string http = "127.0.0.1:" + match[2].str();
  EXPECT_NE(refusal({"--no-render", "--listen", grpc, "--http", "127.0.0.1:0"}).find(grpc), std::string::npos);
  EXPECT_NE(refusal({"--no-render", "--listen", "127.0.0.1:0", "--http", http}).find(http), std::string::npos);
  first.signal(SIGTERM);
  EXPECT_EQ(first.wait(), 0);
}

TEST_F(KerfdTest, ExplainsItself) {
  Kerfd help({"--help"});
  const std::string text = help.rest_of_output();
  EXPECT_EQ(help.wait(), 0);
  for (const char* option :
       {"--listen", "--http", "--scene", "--workers", "--max-sheets", "--max-load", "--max-total-vertices", "--web",
        "--docs", "--no-render", "--render-device", "--list-render-devices", "--record",
        "--max-connections-per-address", "--tokens", "--tls-cert", "--tls-client-ca", "--allow-origin", "--version"}) {
    EXPECT_NE(text.find(option), std::string::npos) << option;
  }
  Kerfd devices({"--list-render-devices"});
  EXPECT_NE(devices.rest_of_output().find(render::make_renderer()->available() ? "* EGL" : "none: "),
            std::string::npos);
  EXPECT_EQ(devices.wait(), 0);
  Kerfd version({"--version"});
  EXPECT_EQ(version.rest_of_output(), std::string("kerfd ") + KERF_VERSION + "\n");
  EXPECT_EQ(version.wait(), 0);
}

app::Config parsed(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "kerfd");
  return std::get<app::Config>(app::parse_command_line(static_cast<int>(arguments.size()), arguments.data()).value());
}

TEST(KerfdConfig, VerticesOfAllSheetsFitInHalfOfTheMemoryUnlessSaidOtherwise) {
  EXPECT_EQ(app::default_total_vertices(std::int64_t{16'000'000'000}), 1'000'000);
  EXPECT_EQ(app::default_total_vertices(std::int64_t{400'000'000}), 25'000) << "a small container";
  EXPECT_EQ(app::default_total_vertices(1), 1) << "0 would be no limit";
  EXPECT_EQ(app::default_total_vertices(0), scene::kMaxVertices) << "where the system does not tell";
  EXPECT_EQ(parsed({}).max_total_vertices, app::default_total_vertices(memory_limit()));
  EXPECT_EQ(parsed({"--max-total-vertices", "0"}).max_total_vertices, 0);
  EXPECT_EQ(parsed({"--max-total-vertices", "1000000000000"}).max_total_vertices, app::kMostTotalVertices);
}

TEST_F(KerfdTest, ConnectionsOfOneAddressAreLimitedUnlessSaidOtherwise) {
  EXPECT_EQ(parsed({}).max_connections_per_address, 128);
  EXPECT_EQ(parsed({"--max-connections-per-address", "0"}).max_connections_per_address, 0);
  EXPECT_EQ(parsed({"--max-connections-per-address", "10000"}).max_connections_per_address, 10'000);
  for (const char* bad : {"-1", "10001", "1.5"}) {
    EXPECT_NE(refusal({"--max-connections-per-address", bad}).find("--max-connections-per-address"), std::string::npos);
  }
}

TEST_F(KerfdTest, FindsTheViewerBesideOrAboveTheProgram) {
  fs::create_directories(folder_ / "tree/build/dev/bin");
  EXPECT_EQ(app::default_web_directory(folder_ / "tree/build/dev/bin/kerfd"), fs::path());
  folder_.write("tree/web/dist/index.html", "x");
  EXPECT_EQ(app::default_web_directory(folder_ / "tree/build/dev/bin/kerfd"), folder_ / "tree/web/dist");
  folder_.write("tree/build/dev/share/kerf/web/index.html", "x");
  EXPECT_EQ(app::default_web_directory(folder_ / "tree/build/dev/bin/kerfd"),
            folder_ / "tree/build/dev/share/kerf/web");
}

TEST_F(KerfdTest, FindsTheDocumentationBesideOrAboveTheProgram) {
  fs::create_directories(folder_ / "tree/build/dev/bin");
  EXPECT_EQ(app::default_docs_directory(folder_ / "tree/build/dev/bin/kerfd"), fs::path());
  folder_.write("tree/build/docs/site/index.html", "x");
  EXPECT_EQ(app::default_docs_directory(folder_ / "tree/build/dev/bin/kerfd"), folder_ / "tree/build/docs/site");
  folder_.write("tree/build/dev/share/kerf/docs/index.html", "x");
  EXPECT_EQ(app::default_docs_directory(folder_ / "tree/build/dev/bin/kerfd"),
            folder_ / "tree/build/dev/share/kerf/docs");
}

}  // namespace
}  // namespace kerf::rpc_test
