import shutil
def sub(p,a,b,n=1):
    s=open(p).read()
    if a not in s: raise SystemExit(f"{p}: not found: {a[:80]}")
    s=s.replace(a,b,n); open(p,'w').write(s)
shutil.copy('/tmp/on/light.rs','src/motion/light.rs')
sub('src/motion/mod.rs','/// What presses friction pairs at a state.','/// Coordinates without inertia that stay.\npub mod light;\n\n/// What presses friction pairs at a state.')
T='src/motion/train.rs'
sub(T,'''        self.accelerate(&mut g);
        for i in 0..n {
            dy[i] = v[i];
            dy[n + i] = g[i] - self.drag * v[i];
        }''','''        let forces = self.has_light().then(|| g.clone());
        self.accelerate(&mut g);
        for i in 0..n {
            dy[i] = v[i];
            dy[n + i] = g[i] - self.drag * v[i];
        }
        if let Some(forces) = forces {
            self.light_rows(regime, (t, y), &forces, dy);
        }''')
s=open(T).read()
a='''            Mass::Diagonal(mass) => g.iter_mut().zip(mass).for_each(|(x, m)| *x /= m),'''
assert a in s
s=s.replace(a,'''            // What has no inertia is not accelerated: its row is another.
            Mass::Diagonal(mass) => g
                .iter_mut()
                .zip(mass)
                .for_each(|(x, m)| *x = if *m == 0.0 { 0.0 } else { *x / m }),''')
s=s.replace('''        self.knows_lines_only()
            && self.branches.iter().all(|b| {
                let linear = match &b.law {
                    Law::Linear { .. } | Law::Maxwell { .. } => true,''','''        self.knows_lines_only()
            && !self.has_light()
            && self.branches.iter().all(|b| {
                let linear = match &b.law {
                    Law::Linear { .. } | Law::Maxwell { .. } => true,''')
s=s.replace('''        self.knows_lines_only()
            && self.branches.iter().all(|b| {
                let linear = match &b.law {
                    Law::Linear { .. } | Law::Maxwell { .. } | Law::Contact(_) => true,''','''        self.knows_lines_only()
            && !self.has_light()
            && self.branches.iter().all(|b| {
                let linear = match &b.law {
                    Law::Linear { .. } | Law::Maxwell { .. } | Law::Contact(_) => true,''')
assert s.count('!self.has_light()')==2
open(T,'w').write(s)
# pencil
P='src/motion/pencil.rs'
s=open(P).read()
s=s.replace('''    /// As it is.
    Plain(Matrix),''','''    /// As it is, and which states have no equation of motion.
    Plain(Matrix, Vec<bool>),''')
s=s.replace('''    fn pencil(&self, t: f64, y: &[f64], effort: &mut Effort) -> Pencil;
}''','''    fn pencil(&self, t: f64, y: &[f64], effort: &mut Effort) -> Pencil;

    /// The state with what has no equation of motion where it must be; absent where there is nothing such.
    ///
    /// # Errors
    /// Nothing says where it is.
    fn consistent(&self, _t: f64, _y: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        Ok(None)
    }
}''')
s=s.replace('''    problem.jacobian(t, y, &mut jacobian);
    effort.jacobians += 1;
    Pencil::Plain(jacobian)
}''','''    problem.jacobian(t, y, &mut jacobian);
    effort.jacobians += 1;
    Pencil::Plain(jacobian, vec![false; n])
}''')
s=s.replace('''        if self.train.inner() > 0 {
            return plain(self, t, y, effort);
        }''','''        if self.train.inner() > 0 || self.train.has_light() {
            let pencil = plain(self, t, y, effort);
            let Pencil::Plain(jacobian, mut algebraic) = pencil else {
                return pencil;
            };
            for state in self.train.algebraic() {
                algebraic[state] = true;
            }
            return Pencil::Plain(jacobian, algebraic);
        }''')
s=s.replace('''            false => exact(self, t, y),
        }
    }
}''','''            false => exact(self, t, y),
        }
    }

    fn consistent(&self, t: f64, y: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        match self.train.has_light() {
            true => self.train.consistent(self.regime, t, y).map(Some),
            false => Ok(None),
        }
    }
}''')
s=s.replace('''            Pencil::Plain(a) => Matrix::from_fn(n, n, |i, j| diagonal(i, j, s) - a[(i, j)]),''','''            Pencil::Plain(a, algebraic) => Matrix::from_fn(n, n, |i, j| {
                let moves = if algebraic[i] { 0.0 } else { diagonal(i, j, s) };
                moves - a[(i, j)]
            }),''')
s=s.replace('''            Pencil::Plain(a) => ComplexMatrix::from_fn(n, n, |i, j| diagonal(i, j) - a[(i, j)]),''','''            Pencil::Plain(a, algebraic) => ComplexMatrix::from_fn(n, n, |i, j| {
                let moves = if algebraic[i] { Complex::ZERO } else { diagonal(i, j) };
                moves - a[(i, j)]
            }),''')
s=s.replace('Pencil::Plain(_) => factored','Pencil::Plain(..) => factored').replace('Pencil::Plain(a) => a.nrows()','Pencil::Plain(a, _) => a.nrows()')
s=s.replace('''    /// The order of the linear systems.''','''    /// One for a state that has an equation of motion, else zero.
    pub fn moves(&self, state: usize) -> f64 {
        match self {
            Pencil::Plain(_, algebraic) if algebraic[state] => 0.0,
            _ => 1.0,
        }
    }

    /// The order of the linear systems.''')
open(P,'w').write(s)
R='src/motion/methods/radau.rs'
s=open(R).read()
s=s.replace('''                .map(|i| into(0, i) - REAL / h * moved[0][i])''','''                .map(|i| into(0, i) - pencil.moves(i) * REAL / h * moved[0][i])''')
s=s.replace('''                        - pair * Complex::new(moved[1][i], moved[2][i])''','''                        - pair * Complex::new(moved[1][i], moved[2][i]) * pencil.moves(i)''')
s=s.replace('''            .map(|i| (0..3).map(|k| ERROR[k] * stages.rise[k][i]).sum::<f64>() / factors.h)''','''            .map(|i| {
                let sum: f64 = (0..3).map(|k| ERROR[k] * stages.rise[k][i]).sum();
                pencil.moves(i) * sum / factors.h
            })''')
a='''        let clock = move |t: f64| inside(t, since, end);
        self.scale.note(y);'''
assert a in s
s=s.replace('''        let since = *self.since.get_or_insert(t);
        let clock = move |t: f64| inside(t, since, end);
        self.scale.note(y);''','''        let begins = self.since.is_none();
        let since = *self.since.get_or_insert(t);
        let clock = move |t: f64| inside(t, since, end);
        let begun = match begins {
            true => problem.consistent(clock(t), y)?,
            false => None,
        };
        let y = begun.as_deref().unwrap_or(y);
        self.scale.note(y);''')
assert s.count('pencil.moves')==3
open(R,'w').write(s)
# massless
M='src/motion/massless.rs'
s=open(M).read()
s=s.replace('''    let mut left: Vec<usize> = massless.to_vec();
    while''','''    let mut left: Vec<usize> = massless.to_vec();
    let mut staying: Vec<usize> = Vec::new();
    while''')
s=s.replace('''        let name = &whole.coordinates[z];
        let (joined''','''        let name = &whole.coordinates[z];
        let plain = |b: &Branch| matches!(b.law, Law::Linear { .. }) && may_stay(b);
        let mut here = branches.iter().filter(|(_, b)| touches(b, z)).map(|(_, b)| b);
        if !here.clone().all(plain) && here.all(may_stay) && !whole.turns_at(z) {
            staying.push(z);
            continue;
        }
        let (joined''')
s=s.replace('''        if let Some((k, c)) = &whole.general
            && (0..whole.n()).any(|j| k[(z, j)] != 0.0 || c[(z, j)] != 0.0)
        {''','''        if whole.turns_at(z) {''')
s=s.replace('''        let mesh = star.mesh(&left)''','''        let light: Vec<usize> = left.iter().chain(&staying).copied().collect();
        let mesh = star.mesh(&light)''')
s=s.replace('''    finished(whole, massless, branches, drives, &followers)''','''    let gone: Vec<usize> = massless
        .iter()
        .copied()
        .filter(|z| !staying.contains(z))
        .collect();
    finished(whole, &gone, branches, drives, &followers)''')
s=s.replace('use super::pressing::unpressed;','use super::light::may_stay;\nuse super::pressing::unpressed;')
open(M,'w').write(s)
L='src/motion/light.rs'
sub(L,'''    /// The rows of coordinates without inertia;''','''    /// Gyroscopic terms or modal damping act on a coordinate.
    pub fn turns_at(&self, coordinate: usize) -> bool {
        self.general.as_ref().is_some_and(|(k, c)| {
            (0..self.n()).any(|j| k[(coordinate, j)] != 0.0 || c[(coordinate, j)] != 0.0)
        })
    }

    /// The rows of coordinates without inertia;''')
H='src/motion/methods/mod.rs'
s=open(H).read()
import re
parts=s.split('refuses: |_| None,')
# radau5 keeps; all others refuse
out=parts[0]
for i,p in enumerate(parts[1:]):
    before=out[-400:]
    name=re.findall(r'name: "([^"]+)"',before)[-1]
    out+=('refuses: |_| None,' if name=='radau5' else 'refuses: light::refused,')+p
s=out.replace('use super::problem::Run;','use super::light;\nuse super::problem::Run;')
open(H,'w').write(s)
sub('src/motion/methods/alpha.rs','''    let pressed = |b: &&Branch|''','''    if let Some(why) = light::refused(train) {
        return Some(why);
    }
    let pressed = |b: &&Branch|''')
sub('src/motion/methods/alpha.rs','use crate::motion::pencil','use crate::motion::light;\nuse crate::motion::pencil')
sub('src/motion/methods/periodic/foreign.rs','''pub fn foreign(train: &Train) -> Option<String> {''','''pub fn foreign(train: &Train) -> Option<String> {
    if let Some(why) = light::refused(train) {
        return Some(why);
    }''')
sub('src/motion/methods/periodic/foreign.rs','use crate::motion::curve::Curve;','use crate::motion::curve::Curve;\nuse crate::motion::light;')
S='src/plan/motion/scene.rs'
sub(S,'''        let outputs = outputs(prepared, &moving, &study.outputs)?;
        let samples''','''        let outputs = outputs(prepared, &moving, &study.outputs)?;
        if moving.train.has_light() {
            start = moving.train.settled(0.0, &start)?;
        }
        let samples''')
sub(S,'''                    let row = row_of(place, &mut outputs);
                    [''','''                    let light = moving.train.light();
                    let follows = |t: &(usize, f64)| light.iter().any(|l| l.coordinate == t.0);
                    if usize::from(times) >= 2 && place.terms.iter().any(follows) {
                        let message = format!("`{name}` is not kept: the node has no inertia");
                        return Err(Error::new(Code::Conflict, message)
                            .hint("ask for its speed, or give the node its inertia, however small"));
                    }
                    let row = row_of(place, &mut outputs);
                    [''')
F='src/response/harmonic/family.rs'
s=open(F).read()
i=s.index('    for (b, &rate) in train.branches.iter().zip(rates) {\n        let followed')
s=s[:i]+'''    if let Some(why) = crate::motion::light::refused(train) {
        return Err(Error::new(Code::Conflict, why)
            .hint("give the node its inertia, however small"));
    }
'''+s[i:]
open(F,'w').write(s)
D='docs/reference/scene-files.md'
sub(D,'''Anything else there (play, waves, errors, motors, brakes) is refused by name: give the node its inertia.''','''Where play without damping of its own or a characteristic acts there too, the node stays as it is: `0 = g` is solved beside the equations of motion (index one), which `radau5` alone does, and the start is put where forces balance; its acceleration is no output. Anything else there (play with damping, waves, errors, motors, friction) is refused by name: give the node its inertia.''')
sub('CHANGELOG.md','''- Friction of bearings''','''- Nodes without inertia at characteristics and at play without damping: `radau5` solves their balance beside the equations of motion.
- Friction of bearings''')
