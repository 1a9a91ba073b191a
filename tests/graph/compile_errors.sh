#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The commonest mistakes in a factor of one's own: what the compiler says first is what is wrong.
#   compile_errors.sh COMPILER SOURCE FLAGS...
set -euo pipefail
compiler=$1 source=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
right=$folder/right.cpp wrong=$folder/wrong.cpp
printf '#include "graph/factor_graph.h"\nusing namespace magimu;\nnamespace {\n' | tee "$right" >"$wrong"
expected=() messages=()

factor() {  # file, name, body: a factor of one row, of a plane vector and a number
  echo "struct $2 : Factor<1, Vector2, double> { using Factor::Factor; $3 };
void use_$2() { FactorGraph g; g.add($2({Key{'p', 0}, Key{'d', 0}}, Noise<1>::isotropic(1.0))); }" >>"$1"
}
mistake() {  # name, body, what is said
  factor "$wrong" "$1" "$2"
  expected+=("$1") messages+=("$3")
}
arguments='must be public, a template over its scalar alone, and take one argument a variable'
base='derives publicly from Factor<rows of its residual'
rows='returns Vec<T, rows>, with the rows of'

factor "$right" Right 'template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d) const
  { return Vec<T, 1>(p[0] - d); }'
factor "$right" Constants 'template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d)
  const { Mat<double, 2, 2> A; A << 1, 2, 3, 4; const Vec<T, 2> q = A * p + 2 * p - Vector2(1, 1);
  return Vec<T, 1>(q[0] * d); }'
factor "$right" ByValue 'template <class T> Vec<T, 1> residual(Vec<T, 2> p, T d) const
  { return Vec<T, 1>(p[0] - d); }'
factor "$right" Deduced 'template <class T, class P> Vec<T, 1> residual(
  const Eigen::MatrixBase<P>& p, const T& d) const { return Vec<T, 1>(p[0] - d); }'
factor "$right" Analytic 'template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d) const
  { return Vec<T, 1>(p[0] - d); }
  template <class T> Vec<T, 1> linearize(const Vec<T, 2>& p, const T& d, Mat<T, 1, 2>& J_p,
  Mat<T, 1, 1>& J_d) const { J_p << T(1.0), T(0.0); J_d << T(-1.0); return Vec<T, 1>(p[0] - d); }'

mistake NoResidual '' 'a factor has a residual: template <class T>'
mistake NotCopied 'NotCopied(const NotCopied&) = delete; template <class T>
  Vec<T, 1> residual(const Vec<T, 2>& p, const T& d) const { return Vec<T, 1>(p[0] - d); }' \
  'the graph keeps a copy of each factor'
mistake NotConst 'template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d)
  { return Vec<T, 1>(p[0] - d); }' 'does not change the factor: declare it const'
mistake NoTemplate 'Vec<double, 1> residual(const Vec<double, 2>& p, const double& d) const
  { return Vec<double, 1>(p[0] - d); }' "$arguments"
mistake OnlyDouble 'template <class T> Vec<T, 1> residual(const Vec<double, 2>& p, double d) const
  { return Vec<T, 1>(T(p[0] - d)); }' 'must work for any scalar T, not for double alone'
mistake TooFew 'template <class T> Vec<T, 1> residual(const Vec<T, 2>& p) const
  { return Vec<T, 1>(p[0]); }' "$arguments"
mistake WrongOrder 'template <class T> Vec<T, 1> residual(const T& d, const Vec<T, 2>& p) const
  { return Vec<T, 1>(p[0] - d); }' "$arguments"
mistake OtherSize 'template <class T> Vec<T, 1> residual(const Vec<T, 3>& p, const T& d) const
  { return Vec<T, 1>(p[0] - d); }' "has another size than the variable"
mistake NotPublic 'private: template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d) const
  { return Vec<T, 1>(p[0] - d); }' "$arguments"
mistake WrongRows 'template <class T> Vec<T, 2> residual(const Vec<T, 2>& p, const T& d) const
  { return Vec<T, 2>(p[0] - d, p[1]); }' "$rows"
mistake ANumber 'template <class T> T residual(const Vec<T, 2>& p, const T& d) const
  { return p[0] - d; }' 'returns a vector, of one row, too'
mistake AnExpression 'template <class T> auto residual(const Vec<T, 2>& p, const T& d) const
  { return p.template head<1>() * d; }' "$rows"
for name in NoBase PrivateBase; do
  parent=
  [ $name = NoBase ] || parent=': private Factor<1, Vector2>'
  constructor="$name() {}"
  [ $name = NoBase ] || constructor="$name() : Factor({Key{'p', 0}}, Noise<1>::isotropic(1.0)) {}"
  echo "class $name $parent { public: $constructor template <class T> Vec<T, 1>
residual(const Vec<T, 2>& p) const { return p.template head<1>(); } };
void use_$name() { FactorGraph g; g.add($name()); }" >>"$wrong"
  expected+=("$name") messages+=("$base")
done
# Fewer keys than variables: std::array would fill up with "?0".
echo "struct FewKeys : Factor<1, Vector2, double> { FewKeys() : Factor({Key{'p', 0}},
  Noise<1>::isotropic(1.0)) {} template <class T> Vec<T, 1> residual(const Vec<T, 2>& p, const T& d)
  const { return Vec<T, 1>(p[0] - d); } };" >"$folder/few.cpp"
{ head -3 "$right"; cat "$folder/few.cpp"; echo '}'; } >"$folder/keys.cpp"
echo '}' | tee -a "$right" >>"$wrong"

flags=(-std=c++20 -fsyntax-only -I"$source" "$@")
"$compiler" "${flags[@]}" "$right" || { echo "right factors do not compile" >&2; exit 1; }
"$compiler" "${flags[@]}" "$wrong" 2>"$folder/said" && { echo "wrong factors compile" >&2; exit 1; }
failed=0 others=()
# A temporary graph would be gone when the optimizer looks at it.
{ echo '#include "solvers/levenberg_marquardt.h"'; echo 'using namespace magimu;
void temporary() { LevenbergMarquardt optimizer{FactorGraph()}; (void)optimizer; }'; } \
  >"$folder/temporary.cpp"
# Types that are no variables.
variable='a variable is a double, a Rot3, or a vector or matrix of double'
body='template <class T> Vec<T, 1> residual(const T& x) const { return Vec<T, 1>(x); } };'
for type in int float 'struct Pose'; do
  name=type_${type##* }
  { head -3 "$right"; echo "${type/struct Pose/struct Pose { double x; \};}" | grep struct || true
    echo "struct F : Factor<1, ${type##* }> { using Factor::Factor; $body
void use() { FactorGraph g; g.add(F({Key{'p', 0}}, Noise<1>::isotropic(1.0))); } }"; } >"$folder/$name.cpp"
  others+=("$name:$variable")
done
for value in 'Eigen::Vector3f(1, 2, 3)' 'Eigen::Quaterniond(1, 0, 0, 0)' 'VectorXd(3)'; do
  name=value_$((${#others[@]} + 1))
  { head -2 "$right"; echo "void insert() { Values v; v.insert(Key{'p', 0}, $value); }"; } >"$folder/$name.cpp"
  others+=("$name:$variable")
done
for wrong_one in "${others[@]}" keys:'one key a variable' temporary:'use of deleted function\|call to deleted'; do
  file=$folder/${wrong_one%%:*}.cpp
  if "$compiler" "${flags[@]}" "$file" 2>"$folder/said_of_it"; then
    echo "${wrong_one%%:*}: it compiles" >&2
    failed=1
  elif ! grep -q "error:.*\(${wrong_one#*:}\)" "$folder/said_of_it"; then
    echo "${wrong_one%%:*}: said: $(grep -m 1 error: "$folder/said_of_it")" >&2
    failed=1
  fi
done
# An error about a factor names it on the lines before (GCC), behind it (clang), or on its own.
clang=0
"$compiler" --version | grep -q clang && clang=1
for i in "${!expected[@]}"; do
  of_it=$(awk -v name="${expected[$i]}" -v clang=$clang '
    function tells() { return $0 ~ "[:<]" name "[]>;, ]" }
    /error:/ { if (mine && !clang || tells()) { print; exit } error = $0; mine = 0 }
    /required from|In instantiation|in instantiation|In substitution/ {
      if (tells()) { mine = 1; if (clang) { print error; exit } } }' "$folder/said")
  if ! grep -qF "magimu: " <<<"$of_it" || ! grep -qF "${messages[$i]}" <<<"$of_it"; then
    echo "${expected[$i]}: expected '${messages[$i]}', said: ${of_it:-nothing}" >&2
    failed=1
  fi
done
# Nothing else is said: no cascade behind a message.
more=$(grep 'error:' "$folder/said" | grep -cv 'magimu: ' || true)
[ "$more" -eq 0 ] || { echo "errors of other kinds:" >&2; grep 'error:' "$folder/said" | grep -v 'magimu: ' >&2; failed=1; }
exit $failed
