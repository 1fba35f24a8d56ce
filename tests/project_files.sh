# Sourced by the checks: sets `root` from the first argument (default: the project's root), changes
# to it, and defines project_files, which lists its files but for what git ignores.

set -euo pipefail
root=$(cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}" && pwd)
cd "$root"

project_files() {
  {
    # Without a repository (an unpacked archive), everything but the build's own folders.
    [[ -e .git ]] && git -c core.quotePath=false ls-files --cached --others --exclude-standard \
      2>/dev/null ||
      find . -type d \( -name .git -o -path ./build -o -path ./results \) -prune -o -type f -print |
      sed 's|^\./||'
  } | sort -u | while IFS= read -r file; do
    # git also lists files that are deleted but not yet committed as such.
    if [[ -f $file ]]; then echo "$file"; fi
  done
}

folders='data|model|ik|dynamics|pipeline'
