#include "client/cli/completion.h"

namespace kerf::cli {
namespace {

// bash also breaks words at '=' and ':'. The script joins such parts again for kerf, and removes from the answers the
// part that bash leaves in place.
constexpr const char* kBash = R"script(# Tab completion of kerf for bash. Now: source <(kerf completion bash)
# For good: kerf completion bash > ~/.local/share/bash-completion/completions/kerf
_kerf() {
  local rest=${COMP_LINE#*"${COMP_WORDS[0]}"} last=${COMP_WORDS[COMP_CWORD]} word trimmed kind line i
  local -a words=() lines=()
  for ((i = 1; i <= COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    trimmed=${rest#"${rest%%[![:blank:]]*}"}
    if ((i == 1)) || [[ $trimmed != "$rest" ]]; then words+=("$word"); else words[-1]+=$word; fi
    rest=${trimmed#"$word"}
  done
  [[ $last == [=:] ]] && last=
  local kept=${words[-1]%"$last"}
  mapfile -t lines < <("${COMP_WORDS[0]/#\~/$HOME}" __complete "${words[@]}" 2>/dev/null)
  kind=${lines[0]}
  COMPREPLY=()
  for line in "${lines[@]:1}"; do
    line=${line%%$'\t'*}
    COMPREPLY+=("${line#"$kept"}")
  done
  case $kind in
    files) compopt -o filenames; while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -f -- "$last") ;;
    folders) compopt -o filenames; while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -d -- "$last") ;;
  esac
}
complete -F _kerf kerf
)script";

constexpr const char* kZsh = R"script(#compdef kerf
# Tab completion of kerf for zsh. Now: source <(kerf completion zsh)
# For good: kerf completion zsh > a folder of $fpath, as _kerf
_kerf() {
  local -a lines candidates
  local line word
  lines=("${(@f)$("${words[1]/#\~/$HOME}" __complete "${(@Q)words[2,CURRENT]}" 2>/dev/null)}")
  for line in "${(@)lines[2,-1]}"; do
    word=${line%%$'\t'*}
    if [[ $line == *$'\t'* ]]; then candidates+=("${word//:/\\:}:${line#*$'\t'}"); else candidates+=("${word//:/\\:}"); fi
  done
  case $lines[1] in
    files) _files ;;
    folders) _files -/ ;;
  esac
  (( $#candidates )) && _describe -V kerf candidates
}
if [[ $funcstack[1] == _kerf ]]; then _kerf "$@"; else compdef _kerf kerf; fi
)script";

constexpr const char* kFish = R"script(# Tab completion of kerf for fish. Now: kerf completion fish | source
# For good: kerf completion fish > ~/.config/fish/completions/kerf.fish
function __kerf_complete
    set -l words (commandline -opc)
    set -l last (commandline -ct)
    set -l lines ($words[1] __complete $words[2..] "$last" 2>/dev/null)
    for line in $lines[2..]
        echo $line
    end
    switch "$lines[1]"
        case files
            __fish_complete_path "$last"
        case folders
            __fish_complete_directories "$last" ""
    end
end
complete -c kerf -e
complete -c kerf -f -k -a "(__kerf_complete)"
)script";

}  // namespace

std::string completion_script(const std::string& shell) {
  if (shell == "bash") return kBash;
  if (shell == "zsh") return kZsh;
  return shell == "fish" ? kFish : "";
}

}  // namespace kerf::cli
