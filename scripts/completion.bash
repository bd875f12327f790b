# SPDX-License-Identifier: Zlib
# Completion of clod-build, clod-bench and clod-bench-float64 in bash. Commands and options are those that the program
# at hand names in its --help, so nothing here can be out of date.
_clod_complete()
{
	local program=$1 word=$2 command="" argument help
	COMPREPLY=()
	for argument in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
		[[ $argument == -* ]] || { command=$argument; break; }
	done
	help=$("$program" ${command:+"$command"} --help 2>/dev/null) || return 0
	if [[ $word == -* ]]; then
		COMPREPLY=($(compgen -W "$(sed -nE 's/^  (-[^ ]*).*/\1/p' <<<"$help" | tr ',' '\n')" -- "$word"))
	elif [[ -z $command ]]; then
		COMPREPLY=($(compgen -W "$(awk '/^Subcommands:/ { inside = 1; next } inside && /^  [a-z]/ { print $1 }' <<<"$help")" -- "$word"))
	fi
}
complete -o default -F _clod_complete clod-build clod-bench clod-bench-float64
