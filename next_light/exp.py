import shutil
def sub(p,a,b,n=1):
    s=open(p).read()
    if a not in s: raise SystemExit(f"{p}: not found: {a[:80]}")
    s=s.replace(a,b,n); open(p,'w').write(s)
shutil.copy('/tmp/on/exponential.rs','src/motion/methods/exponential.rs')
X='src/motion/methods/exponential.rs'
s=open(X).read()
i=s.index('        let sum = |lift: usize| {'); j=s.index('        Kernel {\n            rate,\n            integrals: [sum(0)')
s=s[:i]+'''        let sum = |lift: usize| {
            // τⁿ⁺ˡ/(n + l)!, from n = 1 on.
            let mut power = (1..=lift + 1).fold(1.0, |p, k| p * tau / k as f64);
            let mut all = 0.0;
            for (n, term) in terms.iter().enumerate().skip(1) {
                all += term * power;
                power *= tau / (n + lift + 1) as f64;
            }
            all
        };
        let mut power = 1.0;
        let mut rate = 0.0;
        for (n, term) in terms.iter().enumerate().skip(1) {
            rate += term * power;
            power *= tau / n as f64;
        }
'''+s[j:]
open(X,'w').write(s)
H='src/motion/methods/mod.rs'
sub(H,'/// Newmark\'s and its kin.','/// Exponential, order 4.\npub mod exponential;\n\n/// Newmark\'s and its kin.')
sub(H,'''        run: stepping::radau5,
    },''','''        run: stepping::radau5,
    },
    Method {
        name: "etdrk4",
        title: "exponential Runge–Kutta of order 4 with switches located, the linear part exact",
        ladder: Ladder::Tolerance,
        order: Some(4),
        locates_events: true,
        refuses: |_| None,
        run: exponential::etdrk4,
    },''')
sub('src/motion/methods/stepping.rs','fn control(ask','/// How steps are chosen.\npub fn control(ask')
s=open('src/cli/args.rs').read()
s=s.replace('/// radau5, dop853-events, dop853, dopri5, generalized-alpha-controlled;','/// radau5, etdrk4, dop853-events, dop853, dopri5, generalized-alpha-controlled;')
open('src/cli/args.rs','w').write(s)
sub('docs/how-to.md','`--method` takes another: `dop853-events`,','`--method` takes another: `etdrk4` (exponential: the linear part of each regime exact, for stiff machines with smooth forces that are not linear), `dop853-events`,')
sub('docs/architecture.md','- Friction is one law','- `etdrk4` takes the tangents of a regime as its linear part, in modes of K; kernels of every mode are kept by step length.\n- Friction is one law')
sub('CHANGELOG.md','''- Friction of bearings''','''- `--method etdrk4`: exponential Runge–Kutta of order 4 with error control, the linear part of a machine exact.
- Friction of bearings''')
sub('tests/motion_steps.rs','''        ("radau5", 0.1, 37, 5.0, 4.0),
        ("newmark",''','''        ("radau5", 0.1, 37, 5.0, 4.0),
        ("etdrk4", 0.05, 37, 4.0, 4.0),
        ("newmark",''')
M='tests/support/moving.rs'
s=open(M).read()
a='''    to: f64,
    samples: usize,
) -> Result<Run, Error> {
    let ask'''
assert a in s
s=s.replace(a,'''    to: f64,
    samples: usize,
) -> Result<Run, Error> {
    run_with(method, train, start, to, samples, Wanted::Tolerance(1e-12))
}

/// The same, as exactly or as finely as said.
pub fn run_with(
    method: &str,
    train: &Train,
    start: &[f64],
    to: f64,
    samples: usize,
    effort: Wanted,
) -> Result<Run, Error> {
    let ask''').replace('        effort: Wanted::Tolerance(1e-12),\n','        effort,\n')
open(M,'w').write(s)
shutil.copy('/tmp/on/exponential_test.rs','tests/exponential.rs')
