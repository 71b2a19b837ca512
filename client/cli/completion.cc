#include "client/cli/completion.h"

#include <algorithm>
#include <set>

#include "client/cli/app.h"

namespace kerf::cli {
namespace {

bool begins_with(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

// Finds an option by name, of the command or of its parents, whose options may follow it too.
const CLI::Option* find_option(const CLI::App* command, const std::string& name) {
  for (; command != nullptr; command = command->get_parent()) {
    if (const CLI::Option* option = command->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

// Describes where in the command line the last word stands, from the words before it.
struct Place {
  const CLI::App* command = nullptr;
  std::set<const CLI::Option*> given;
  const CLI::Option* open = nullptr;  // Option whose value the last word is; null: none.
  std::size_t arguments = 0;          // Arguments of the command before the last word.
  bool only_arguments = false;        // True after "--".
  ServerTarget server;

  void take_value(const CLI::Option& option, const std::string& value) {
    const std::string name = option_name(option);
    if (name == "--server") server.address = value;
    if (name == "--token-file") server.credentials.token_file = value;
    if (name == "--tls-ca") server.credentials.tls_ca = value;
    if (name == "--tls-cert") server.credentials.tls_cert = value;
    if (name == "--tls-key") server.credentials.tls_key = value;
  }
  void take_option(const std::string& word) {
    const std::size_t equals = word.find('=');
    const CLI::Option* option = find_option(command, word.substr(0, equals));
    if (option == nullptr) return;
    given.insert(option);
    if (option_name(*option) == "--tls") server.credentials.use_tls = true;
    if (equals != std::string::npos) {
      take_value(*option, word.substr(equals + 1));
    } else if (takes_value(*option)) {
      open = option;
    }
  }
  void take(const std::string& word) {
    if (open != nullptr) {
      take_value(*open, word);
      open = nullptr;
    } else if (word == "--") {
      only_arguments = true;
    } else if (!only_arguments && word.size() > 1 && word.front() == '-') {
      take_option(word);
    } else if (const CLI::App* next = find_command(word); next != nullptr) {
      command = next;
      arguments = 0;
    } else {
      ++arguments;
    }
  }
  [[nodiscard]] const CLI::App* find_command(const std::string& word) const {
    for (const CLI::App* each : commands_of(*command)) {
      if (each->check_name(word)) return each;
    }
    return nullptr;
  }
};

void add(const std::string& word, const std::string& description, const std::string& typed, Completion& completion) {
  if (begins_with(word, typed)) completion.candidates.push_back({word, headline(description)});
}

// `before`: the part of the word before the value, as in --pin=top.
void add_values(const CLI::Option& option, const Place& place, const ServerNames& names, const std::string& before,
                const std::string& typed, Completion& completion) {
  std::vector<std::string> values = choices_of(option);
  if (has_values(option, value::kSheet)) values = names.sheets(place.server);
  if (has_values(option, value::kMaterial)) values = names.materials(place.server);
  for (const std::string& value : values) add(before + value, "", typed, completion);
  if (has_values(option, value::kFile)) completion.paths = Completion::Paths::kFiles;
  if (has_values(option, value::kFolder)) completion.paths = Completion::Paths::kFolders;
}

void add_options(const Place& place, const std::string& typed, Completion& completion) {
  for (const CLI::App* command = place.command; command != nullptr; command = command->get_parent()) {
    for (const CLI::Option* option : options_of(*command)) {
      // Skips inherited --help, since each command has its own.
      const bool inherited = command != place.command && option == command->get_help_ptr();
      const bool again = place.given.count(option) > 0 && !is_repeatable(*option);
      if (!inherited && !again) add(option_name(*option), option->get_description(), typed, completion);
    }
  }
}

}  // namespace

Completion complete(const CLI::App& app, const std::vector<std::string>& words, const ServerTarget& server,
                    const ServerNames& names) {
  Place place;
  place.command = &app;
  place.server = server;
  const std::string typed = words.empty() ? std::string() : words.back();
  for (std::size_t i = 0; i + 1 < words.size(); ++i) place.take(words[i]);

  Completion completion;
  if (place.open != nullptr) {
    add_values(*place.open, place, names, "", typed, completion);
    return completion;
  }
  if (!place.only_arguments && !typed.empty() && typed.front() == '-') {
    const std::size_t equals = typed.find('=');
    if (equals == std::string::npos) {
      add_options(place, typed, completion);
    } else if (const CLI::Option* option = find_option(place.command, typed.substr(0, equals))) {
      add_values(*option, place, names, typed.substr(0, equals + 1), typed, completion);
    }
    return completion;
  }
  for (const CLI::App* command : commands_of(*place.command)) {
    add(command->get_name(), command->get_description(), typed, completion);
  }
  const std::vector<const CLI::Option*> arguments = arguments_of(*place.command);
  if (place.arguments < arguments.size()) {
    add_values(*arguments[place.arguments], place, names, "", typed, completion);
  }
  return completion;
}

std::string to_lines(const Completion& completion) {
  std::string lines = "words\n";
  if (completion.paths == Completion::Paths::kFiles) lines = "files\n";
  if (completion.paths == Completion::Paths::kFolders) lines = "folders\n";
  for (const Candidate& candidate : completion.candidates) {
    lines += candidate.word + (candidate.description.empty() ? "" : "\t" + candidate.description) + "\n";
  }
  return lines;
}

}  // namespace kerf::cli
