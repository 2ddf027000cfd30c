#!/bin/sh
# Writes the manual pages of the program, and what completes its command line in a shell, where shells and `man` look for
# them below a folder such as /usr/local/share:
#
#     packaging/share.sh PROGRAM FOLDER
set -eu

program=$1
share=$2

umask 022
mkdir -p "$share/bash-completion/completions" "$share/zsh/site-functions" "$share/fish/vendor_completions.d" \
    "$share/stickslip/completions"
"$program" man --out "$share/man/man1" >/dev/null
"$program" completions bash >"$share/bash-completion/completions/stickslip"
"$program" completions zsh >"$share/zsh/site-functions/_stickslip"
"$program" completions fish >"$share/fish/vendor_completions.d/stickslip.fish"
# These shells look nowhere by themselves: the file is named in the user's own settings.
"$program" completions elvish >"$share/stickslip/completions/stickslip.elv"
"$program" completions powershell >"$share/stickslip/completions/stickslip.ps1"
